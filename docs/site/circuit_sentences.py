"""What the tables of docs/circuits-compared.md say, in sentences made from their numbers."""

import re
from collections.abc import Iterator, Mapping, Sequence

NONE = 0.005
"""A power below which nothing is lost [W]."""
ALONE = ("triangle", "heavy", "digging")
"""The cycles of one cylinder, in the order in which sentences name them."""
NET, DEAR_NET = "net, favourable pump", "net, unfavourable pump"
THROTTLE = "meter-out throttle"
"""Heads of columns, without their units."""


def short(value: float) -> str:
    """A value with three digits, none for what is less than a hundredth."""
    if abs(value) < NONE:
        return "0"
    text = f"{value:.3g}"
    return f"{float(text):.0f}" if "e" in text or abs(value) >= 1000.0 else text


def kept_table(page: str, name: str) -> list[str]:
    """The lines of the table of a cycle on the page."""
    return page.partition(f"**{name}**:")[2].partition("\n\n**")[0].partition("<!--")[0].splitlines()


def numbers(row: str) -> list[float]:
    """The numbers of a row, without its first cell."""
    return [float(cell) for cell in re.findall(r"(?<=\| )-?[\d.]+(?= \|)", row)]


def columns(page: str, name: str) -> dict[str, dict[str, float]]:
    """The numbers of the table of a cycle on the page, by circuit and head of the column, without units."""
    lines = kept_table(page, name)
    (head,) = (line for line in lines if line.startswith("| circuit "))
    heads = [cell.strip().partition(" [")[0] for cell in head.split("|")[2:-1]]
    found = {line.split("`")[1]: numbers(line) for line in lines if line.startswith("| `")}
    return {circuit: dict(zip(heads, row, strict=True)) for circuit, row in found.items()}


def listed(values: Sequence[float]) -> str:
    """Three values in words, with three digits."""
    return "{}, {} and {}".format(*map(short, values))


def flowed(text: str) -> str:
    """A text on one line."""
    return " ".join(text.split())


def power_sentences(page: str) -> Iterator[str]:
    """What the tables of the page say of powers on the cycles of one cylinder."""
    cycles = [columns(page, name) for name in ALONE]

    def net(circuit: str, head: str = NET) -> str:
        return listed([cycle[circuit][head] for cycle in cycles])

    def over(a: str, b: str, digits: int = 1) -> str:
        ratios = (f"{cycle[a][NET] / cycle[b][NET]:.{digits}f}" for cycle in cycles)
        return "{}, {} and {}".format(*ratios)

    yield f"""- **Load sensing draws less than the VVDP on every cycle** with the favourable pump:
        {net("load-sensing")} W on triangle, heavy and digging compared with {net("vvdp")} W, and
        {net("vvdp-slow")} W with two thirds of the pump's speed. The VVDP draws {over("vvdp", "load-sensing")}
        times as much, at the lower speed {over("vvdp-slow", "load-sensing")} times. What load sensing loses
        grows with the flow that is used, what the rotary valve loses with the flow of the pump, used or not."""
    yield f"""- **Independent metering draws less than load sensing**: {net("independent-valves")} W by proportional
        valves, {net("independent-units")} W by digital flow control units. Its margin is 10 bar instead of 20,
        since neither a compensator nor a directional valve lies before the cylinder; with a margin of 10 bar
        load sensing would draw as much ([below](#what-is-assumed-and-how-much-it-matters)). One unit that
        meters in from a fixed pump at its relief setting (`flow-control-unit`) draws {net("flow-control-unit")}
        W: the supply makes the difference, not the unit."""
    yield f"""- A fixed pump that is bled off draws {net("bleed-off")} W; it feeds one cylinder only. A pump that
        holds one pressure draws {net("constant-pressure")} W, {over("constant-pressure", "load-sensing")} times
        what load sensing draws."""
    yield f"""- Throttling draws {over("throttle", "vvdp")} times as much as the VVDP. An ideal pump one way draws
        {net("ideal-pump")} W: on the triangle 40 L/min circulate through the rotary valve for the 3 to 7 L/min
        that the cylinder takes. A relief valve that follows the line (`vvdp-following`) brings the VVDP to
        {net("vvdp-following")} W."""
    lost = (cycle["measured-pump"]["pump friction"] for cycle in cycles)
    yield f"""- **Pumps with losses of their own, in the circuit of the ideal one**: with those of a measured axial
        piston pump it draws {net("measured-pump")} W, with twelve pistons that are enabled one by one
        {net("digital-pump")} W, {over("digital-pump", "load-sensing")} times what load sensing draws. The
        measured pump loses {listed(list(lost))} W by friction, less than the drag of 942 W that the unfavourable
        pump has; the inlet valves of the pistons take
        {listed([cycle["digital-pump"]["piston valves"] for cycle in cycles])} W, closing them included."""
    yield f"""- **With the unfavourable pump**, a drag of 942 W and three times the leakage, load sensing draws
        {net("load-sensing", DEAR_NET)} W, `independent-valves` {net("independent-valves", DEAR_NET)} W, the
        VVDP {net("vvdp", DEAR_NET)} W, `vvdp-slow` {net("vvdp-slow", DEAR_NET)} W and `ideal-pump`
        {net("ideal-pump", DEAR_NET)} W: every pump drags, whatever it gives, so the ratios shrink. The machine
        whose pump turns slower has a smaller drag, and draws within 10 % of what load sensing draws."""


def loss_sentences(page: str) -> Iterator[str]:
    """What the tables of the page say of single losses, recovered power, errors and pressures."""
    triangle, heavy, digging = (columns(page, name) for name in ALONE)
    published, common, sensing, ideal = (
        heavy[name] for name in ("vvdp-chapter-6", "vvdp", "load-sensing", "ideal-pump")
    )
    yield f"""- **The law of the meter-out throttle counts.** Under the heavy load `vvdp-chapter-6` draws
        {short(published[NET])} W and loses {short(published[THROTTLE])} W over this throttle, `vvdp` with the
        law of all rivals {short(common[NET])} W and {short(common[THROTTLE])} W. `ideal-pump` loses
        {short(ideal[THROTTLE])} W there, load sensing {short(sensing[THROTTLE])} W. With one law the VVDP draws
        {common[NET] / sensing[NET]:.1f} times what load sensing draws, by its own
        {published[NET] / sensing[NET]:.1f} times."""
    pumps = [heavy[name] for name in ("shuttle", "pilot-checks", "four-valves")]
    given = [100.0 * row["returned"] / row["received"] for row in pumps]
    yield f"""- The circuits whose pump goes overcentre give back {min(given):.0f} to {max(given):.0f} % of what they
        receive under the heavy load, and draw {listed([row[NET] for row in pumps])} W net. The charge pump of
        the closed ones costs {short(triangle["shuttle"]["charge relief"])} W on the triangle, most of what they
        draw there."""
    errors = {name: row["largest"] for name, row in heavy.items()}
    worst = sorted(errors, key=lambda name: errors[name])[:-4:-1]
    strays = ", ".join(f"`{name}` ({short(errors[name])} mm)" for name in worst)
    yield f"""- At one rms error the largest errors differ, under the heavy load from {short(min(errors.values()))} to
        {short(max(errors.values()))} mm. The largest are those of {strays}: these circuits stray where the
        load's pressure changes, and follow closely otherwise."""
    lowest = min((row["lowest"], name) for cycle in (triangle, heavy, digging) for name, row in cycle.items())
    yield f"""- Digging, pressures in the machine's chambers go to {short(digging["vvdp-chapter-6"]["highest"])} bar
        by its own laws with its relief valve at 100, which limits the pump and not a chamber that the
        directional valve has closed off; by the common loop to {short(digging["vvdp"]["highest"])} bar. The
        lowest pressure of all is {short(lowest[0])} bar, of `{lowest[1]}`."""


def rows_between(page: str, begin: str, end: str) -> dict[str, list[float]]:
    """The numbers of the table between two marks, by its first cell."""
    lines = page.partition(begin)[2].partition(end)[0].strip().splitlines()[2:]
    return {line.split("|")[1].strip().strip("`"): numbers(line) for line in lines}


SHARING, OWN = ("independent-valves", "load-sensing"), ("ideal-pump", "four-valves", "vvdp-slow")
"""Circuits whose pump feeds all cylinders, and some that have a pump for each."""


def load_sentences(page: str, rows: Mapping[str, Sequence[float]]) -> Iterator[str]:
    """What the tables say of one to three cylinders; `rows` are the numbers of their own table by circuit."""
    three = columns(page, "three-loads")

    def over(a: str, b: str) -> str:
        return "{}, {} and {}".format(*(f"{x / y:.1f}" for x, y in zip(rows[a], rows[b], strict=True)))

    yield f"""Input power minus recovered power. Over a pump for each, `ideal-pump`, load sensing draws
        {over("load-sensing", "ideal-pump")} times as much for one, two and three cylinders, since every
        cylinder takes its flow at the pressure of the highest load: that is what wang2017, section 1.2.6, says
        against load sensing, and what displacement control saves. The VVDP does not: a machine of 40 L/min for
        each cylinder circulates as much for a small one as for a large one, and draws
        {over("vvdp", "load-sensing")} times what load sensing does, {over("vvdp-slow", "load-sensing")} times
        at the lower speed. Independent metering by proportional valves draws
        {over("independent-valves", "load-sensing")} times what load sensing does."""
    shared, apart = (
        ", ".join(f"`{name}` {short(three[name][DEAR_NET])} W" for name in names) for names in (SHARING, OWN)
    )
    yield f"""**With pumps that drag, one pump for all is worth most.** Three cylinders by one unfavourable pump draw:
        {shared}; by a pump for each: {apart}. Three drags of 942 W are more than what the compensators lose."""


def spread_sentences(rows: Mapping[str, Sequence[float]]) -> Iterator[str]:
    """What the table of assumed values says; `rows` are its numbers by circuit and what is changed."""
    dear = "{}, all of these"
    sensing, machine, slow = (rows[dear.format(name)] for name in ("load-sensing", "vvdp", "vvdp-slow"))
    low, high = (rows[f"load-sensing, margin {margin} bar"] for margin in (10, 30))
    yield f"""A friction torque costs every pump at 1800 rpm the same 942 W, whatever it gives, and moves no
        difference between circuits of one pump each. A leak costs the most where the pressure is high and the
        flow small, as in `constant-pressure`; throttling and bleeding off draw less for it, since a fixed pump
        has less to lose over a valve. With a margin of 10 to 30 bar load sensing draws {short(low[0])} to
        {short(high[0])} W on the triangle and {short(low[1])} to {short(high[1])} W under the heavy load. With
        all of it at the unfavourable end of its range load sensing draws {short(sensing[0])} W on the triangle
        and {short(sensing[1])} W under the heavy load, the VVDP with the same pump {short(machine[0])} and
        {short(machine[1])} W, at the lower speed {short(slow[0])} and {short(slow[1])} W. **So at the
        unfavourable end of all ranges the machine with the slower pump draws less than load sensing**, and at
        no other end."""
    good, poor = (rows[f"digital-pump{end}"] for end in ("", ", all of these"))
    less, more = (rows[f"digital-pump, valve energy {energy} J"] for energy in ("0.05", "0.5"))
    yield f"""Nothing of the pump of enabled pistons is measured either. With a valve energy of 0.05 to 0.5 J it draws
        {short(less[0])} to {short(more[0])} W on the triangle and {short(less[1])} to {short(more[1])} W under
        the heavy load; with all of it at the unfavourable end, drag included, {short(poor[0])} and
        {short(poor[1])} W instead of {short(good[0])} and {short(good[1])} W."""


def sentences(page: str) -> Iterator[str]:
    """What the tables of the page say, so that no sentence differs from its table."""
    yield from map(flowed, power_sentences(page))
    yield from map(flowed, loss_sentences(page))
    yield ""
