"""What a test does on the page, again and again."""

import time


def wait_for(page, expression, patience=30.0):
    """Waits until a JavaScript expression is true."""
    ends = time.monotonic() + patience
    while not page.ask(expression):
        assert time.monotonic() < ends, (expression, page.ask("document.getElementById('state').textContent"))
        time.sleep(0.03)


COMPLETE = "document.getElementById('state')?.textContent === 'run complete'"
DUTY = "document.getElementById('value-operation.duty_ratio')"


def middle(page, expression):
    box = "const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2];"
    return page.ask(f"(() => {{ const e = {expression}; e.scrollIntoView({{block: 'center'}}); {box} }})()")


def enter(page, element, value, event="input"):
    """Puts a value into a field, as typing or dragging does."""
    change = f"e.value = '{value}'; e.dispatchEvent(new Event('{event}'));"
    page.ask(f"(() => {{ const e = {element}; {change} }})()")
