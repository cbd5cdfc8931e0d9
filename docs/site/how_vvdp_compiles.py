"""Writes the page on compilation: one law as Python, tree and LLVM text. `python docs/site/how_vvdp_compiles.py`"""

import inspect
from pathlib import Path

from vvdp.generator.kinds import FLOAT, kind_of
from vvdp.generator.llvm_writer import write_llvm
from vvdp.generator.python_writer import write_python
from vvdp.generator.tree import Module
from vvdp.generator.unit import Unit
from vvdp.generator.verify import verify
from vvdp.hydraulics.orifice import Orifice, orifice_flow
from vvdp.simulation.dialect import model_options

DOCS = Path(__file__).parents[1]
PAGE = """# How vvdp compiles

A circuit, a program and the simulation loop are plain Python functions. vvdp compiles them with its own
generator, `vvdp.generator`, in seconds and to the same bits on every run. This page follows one law from Python
to machine code; `python docs/site/how_vvdp_compiles.py` writes it. The constructs that may be used are on [the
page of the language](language.md), the rules of arithmetic on [another](models/arithmetic.md).

## 1. Python

The flow through an orifice, without its docstring:

```python
{python}
```

The generator reads this text (`ast`, never bytecode), the text of every function that it calls, and the
constants of its module. Parameters are a record; what is known before is calculated now.

## 2. The typed tree

Each name has a type, each function one version per combination of argument types. The verifier checks types,
one assignment for each variable, and values before their use. Printed back as Python, which CPython runs with
the same bits as the machine code:

```python
{tree}
```

## 3. LLVM text

```llvm
{llvm}
```

Sums are not regrouped and products are not fused with sums. A record is handed over by its address, a call of
the C library is marked so that LLVM does not replace it. `vvdp show FILE --llvm` prints this text for a whole
circuit and its programs, with the file and line of each instruction.

## 4. Object code

llvmlite compiles the text for this processor. The object code is kept in the cache under the hash of all that
it was made from: the texts of the functions, the constants, the generator, the versions of Python, NumPy and
LLVM. The next process loads it. What each part costs, `python -m benchmarks.start_up` measures.

| part | compiled again if |
|---|---|
| circuit: rates, jumps, events, conditions, outputs | its components, wiring or a formula change; not for a value |
| sensor of a program | what it reads changes |
| step of a program | its law or a constant of it changes; not for a setting |
| simulation loop | vvdp or llvmlite is updated |
"""


def module() -> Module:
    """The tree of the law."""
    unit = Unit(model_options())
    unit.add(orifice_flow, [FLOAT, FLOAT, FLOAT, kind_of(Orifice())], "orifice_flow")
    return verify(unit.module())


def python_text() -> str:
    """The law without its docstring."""
    text = inspect.getsource(orifice_flow)
    head, _, rest = text.partition('    """')
    return head + rest.partition('"""\n')[2].rstrip()


def page() -> str:
    """The whole page."""
    made = module()
    tree = "\n".join(line for line in write_python(made).splitlines() if not line.strip().startswith("#"))
    llvm = "\n".join(line for line in write_llvm(made).splitlines() if line and not line.startswith("!"))
    return PAGE.format(python=python_text(), tree=tree.strip(), llvm=llvm)


if __name__ == "__main__":
    (DOCS / "how-vvdp-compiles.md").write_text(page(), "utf-8")
