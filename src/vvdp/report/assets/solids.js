"use strict";

const SHADERS = {
  VERTEX_SHADER: `#version 300 es
    in vec3 place;
    uniform vec3 centre;
    uniform vec3 scale;
    uniform mat3 turn;
    out vec3 seen;
    void main() {
      seen = turn * (place - centre);
      gl_Position = vec4(seen * scale, 1.0);
    }`,
  FRAGMENT_SHADER: `#version 300 es
    precision highp float;
    in vec3 seen;
    uniform vec3 paint;
    out vec4 colour;
    const vec3 LAMP = normalize(vec3(-0.35, 0.55, 0.76));
    void main() {
      vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
      colour = vec4(paint * (0.42 + 0.58 * max(dot(normal, LAMP), 0.0)), 1.0);
    }`,
};
const ANGLE = 0.12;
/** Turns about the axes of the screen by keys [rad]. */
const TURNS = { ArrowLeft: [-ANGLE, 0], ArrowRight: [ANGLE, 0], ArrowUp: [0, -ANGLE], ArrowDown: [0, ANGLE] };

/** Flat shaded solids, seen in parallel projection and turned with mouse or keys. */
class SolidView {
  constructor(node, described, corners) {
    this.canvas = node.querySelector("canvas");
    this.described = described;
    this.shown = new Set(described.parts.map((part) => part.name));
    this.gl = this.canvas.getContext("webgl2", { antialias: true });
    if (!this.gl) return;
    node.hidden = false;
    node.prepend(...described.parts.map((part) => this.#box(part.name)));
    this.#open(corners);
    this.#listen();
    this.reset();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  reset() {
    this.turn = this.described.turn;
    this.zoom = 1;
    this.draw();
  }

  #open(corners) {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, text] of Object.entries(SHADERS)) {
      const shader = gl.createShader(gl[kind]);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    gl.useProgram(program);
    this.at = (name) => gl.getUniformLocation(program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, corners, gl.STATIC_DRAW);
    const place = gl.getAttribLocation(program, "place");
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, gl.UNSIGNED_SHORT, false, 0, 0);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(1, 1, 1, 1);
  }

  draw() {
    const { gl, canvas, described } = this;
    const width = canvas.clientWidth, height = canvas.clientHeight, ratio = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const scale = (1.85 * this.zoom) / described.size;
    gl.uniform3f(this.at("scale"), scale, (scale * width) / height, -0.9 / described.size);
    gl.uniform3fv(this.at("centre"), described.centre);
    gl.uniformMatrix3fv(this.at("turn"), true, this.turn.flat());
    let first = 0;
    for (const part of described.parts) {
      for (const { colour, count } of part.patches) {
        gl.uniform3fv(this.at("paint"), colour);
        if (this.shown.has(part.name)) gl.drawArrays(gl.TRIANGLES, first, count);
        first += count;
      }
    }
  }

  /** Turns what is seen about the upright and the level axis of the screen [rad]. */
  rotate(aside, down) {
    const [c, s, d, t] = [Math.cos(aside), Math.sin(aside), Math.cos(down), Math.sin(down)];
    const step = [[c, 0, s], [s * t, d, -c * t], [-s * d, t, c * d]];
    const column = (j) => this.turn.map((row) => row[j]);
    this.turn = step.map((row) => [0, 1, 2].map((j) => row.reduce((sum, each, k) => sum + each * column(j)[k], 0)));
    this.draw();
  }

  #listen() {
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) this.rotate(0.01 * event.movementX, 0.01 * event.movementY);
    });
    canvas.addEventListener("dblclick", () => this.reset());
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      this.zoom = Math.min(Math.max(this.zoom * Math.exp(-0.002 * event.deltaY), 0.5), 20);
      this.draw();
    });
    canvas.addEventListener("keydown", (event) => {
      if (!(event.key in TURNS)) return;
      event.preventDefault();
      this.rotate(...TURNS[event.key]);
    });
  }

  /** A box that shows or hides a part. */
  #box(name) {
    const label = document.createElement("label");
    const box = document.createElement("input");
    box.type = "checkbox";
    box.checked = true;
    box.addEventListener("change", () => {
      this.shown[box.checked ? "add" : "delete"](name);
      this.draw();
    });
    label.append(box, ` ${name}`);
    return label;
  }
}

async function openSolids() {
  const described = JSON.parse(document.getElementById("solids-data").textContent);
  const packed = Uint8Array.from(atob(described.bytes), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const corners = new Uint16Array(await new Response(stream).arrayBuffer());
  window.solids = new SolidView(document.getElementById("solids"), described, corners);
}

openSolids();
