"""Markdown tables made from the objects: the paper's map, waves, scenes, observables, schemes."""

import json
from collections.abc import Iterable, Iterator, Sequence

from house import HOUSE, ROOMS
from longwave.lattice.schemes import SCHEMES, stability_limit
from longwave.reports.formulas.printing import latex
from longwave.reports.latex import domain_latex
from longwave.reports.pictures.paper_figures import ERROR_FIGURES, SNAPSHOT_FIGURES
from longwave.scenes.description.bench import KEYS
from longwave.scenes.description.named_scenes import load_scene, shipped_scenes
from longwave.scenes.description.scene import Scene
from longwave.scenes.observed.observables import OBSERVABLES
from longwave.solutions import CATALOGUE, ClosedForm
from longwave.verify.kernel.table import RULES
from longwave.verify.published import published
from paper_map import Holder, Row, paper_map

MOST_OPERATIONS = 20
"""Most operations of a formula that is shown in a cell of a table."""


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table.

    >>> print(table(["wave", "s"], [["kink", "-1"]]))
    | wave | s |
    |---|---|
    | kink | -1 |
    """
    cells = ([cell.replace("|", r"\|") for cell in row] for row in (head, *rows))
    lines = [f"| {' | '.join(row)} |" for row in cells]
    return "\n".join([lines[0], f"|{'---|' * len(head)}", *lines[1:]])


def paper_table() -> str:
    """Return the paper's map: number, label, objects, their files, and scenes of figures."""
    rows = [
        [
            row.place.replace(" ", "&nbsp;"),
            f"{'' if row.label in row.place else row.label}{_scenes_of(row)}",
            _targets(row.holders),
            _files(row.holders),
        ]
        for row in paper_map(HOUSE, ROOMS)
    ]
    return table(["paper", "its label", "object", "file"], rows)


def _scenes_of(row: Row) -> str:
    """Return the scenes from which a figure is drawn, in words."""
    drawn = {figure.label: figure.scenes for figure in SNAPSHOT_FIGURES}
    for figure in ERROR_FIGURES:
        drawn[figure.label] = tuple(name for _, pairs in figure.panels for _, name in pairs)
    if row.label not in drawn:
        return ""
    return "; scenes " + ", ".join(f"`{name}`" for name in drawn[row.label])


def _targets(holders: Iterable[Holder]) -> str:
    return "<br>".join(f"{{py:{holder.kind}}}`~{holder.target}`" for holder in holders)


def _files(holders: Iterable[Holder]) -> str:
    return "<br>".join(f"`{holder.path.as_posix()}`" for holder in holders)


def waves() -> str:
    """Return the closed forms by equation: name, title, domains, and a formula if it is short."""
    head = ["wave", "parameters", "$U$"]
    return "\n\n".join(
        f"### {equation}\n\n"
        + table(head, [_wave_row(form) for form in CATALOGUE if form.equation.name == equation])
        for equation in dict.fromkeys(form.equation.name for form in CATALOGUE)
    )


def _wave_row(form: ClosedForm) -> list[str]:
    domains = "<br>".join(domain_latex(parameter.domain) for parameter in form.parameters)
    return [f"`{form.name}`<br>{form.title}", domains, _formula(form)]


def _formula(form: ClosedForm) -> str:
    if form.expression.count_ops() > MOST_OPERATIONS:
        return f"{{py:mod}}`~{CATALOGUE.module(form.name)}`"
    return f"$\\displaystyle {latex(form.expression)}$"


def scenes() -> str:
    """Return the shipped scenes, the paper's first: name, title, wave, eps, times, method."""
    return table(
        ["scene", "wave", "$\\epsilon$", "times", "computed"],
        (
            list(_scene_row(load_scene(name)))
            for name in (*shipped_scenes(), *shipped_scenes("further"))
        ),
    )


def _scene_row(scene: Scene) -> Iterator[str]:
    yield f"`{scene.name}`<br>{scene.title}"
    yield f"`{scene.wave_name}`"
    yield f"{scene.eps:g}"
    yield f"{scene.t0:g} to {scene.end:g}"
    yield str(scene.numerics)


def observables() -> str:
    """Return the observables: name, meaning, and the arrays they add to a run."""
    rows = [
        [
            f"`{entry.name}`",
            entry.summary + (" (on a ring only)" if entry.needs_ring else ""),
            ", ".join(f"`{variable.name}`" for variable in entry.variables),
        ]
        for entry in OBSERVABLES.values()
    ]
    return table(["observable", "what", "arrays"], rows)


def bench_keys() -> str:
    """Return a table of the keys of a chain on a bench: table, key, meaning, default."""
    return table(
        ["table", "key", "what", "unless stated"],
        (
            [f"`{name}`", f"`{key}`", entry.meaning, _default_text(entry.default)]
            for name, entries in KEYS.items()
            for key, entry in entries.items()
        ),
    )


def _default_text(value: object) -> str:
    """Return a default value as it is written in a file; empty for an omitted key."""
    is_shown = type(value) is int or (value and isinstance(value, str | tuple))
    return f"`{json.dumps(value)}`" if is_shown else ""


def schemes() -> str:
    """Return the schemes: name, order, force evaluations per step, stability limit, source."""
    rows = [
        [
            f"`{scheme.name}`",
            str(scheme.order),
            str(scheme.stages),
            f"{stability_limit(scheme):.2f}",
            scheme.reference,
        ]
        for scheme in SCHEMES
    ]
    limit = "step $\\times$ highest frequency"
    return table(["scheme", "order", "forces a step", limit, "from"], rows)


def misprints() -> str:
    """Return the misprints found in publications: name, publication, error."""
    rows = [
        [f"`{text.name}`", linked(text.misprint_in, text.looked_up), text.note]
        for text in published()
        if text.misprint_in
    ]
    return table(["statement", "publication", "what is wrong"], rows)


def linked(words: str, address: str) -> str:
    """Return the text, as a link if there is an address."""
    return f"[{words}]({address})" if address else words


def kernel_rules() -> str:
    """Return the kernel's rules in the order in which they are tried, with their assumptions.

    >>> "| image | Pow | `root_rules.root` |" in kernel_rules()
    True
    """
    rows = [
        [
            rule.question,
            ", ".join(rule.functions),
            f"`{rule.answer.__module__.rpartition('.')[2]}.{rule.answer.__name__}`",
            rule.assumes,
        ]
        for rule in RULES.rows
    ]
    return table(["question", "of", "rule", "assumes"], rows)
