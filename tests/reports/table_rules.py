"""Rules for the report's LaTeX: numbered tables, mathematics, floats, margins."""

import re

TABLE = re.compile(r"\\begin\{longtable\}.*?\\end\{longtable\}", re.DOTALL)

SYNTAX = re.compile(r"\*\*|\w\*\w|(?<!\\)\b(?:sqrt|exp|diff|abs)\(|jacobi_")
"""Pattern of the syntax of formulas as text, which must not appear in mathematics."""

WIDEST = 5.0
"""Largest width, in points, by which a line may exceed the margin."""


def faults_of_tables(tex: str) -> list[str]:
    """Return the faults of the tables in a LaTeX source."""
    found = [] if not re.search(r"\\begin\{tabular", tex) else ["a table without a number"]
    labels = re.findall(r"\\label\{(tab:\w+)\}", tex)
    found += [f"{label} twice" for label in {*labels} if labels.count(label) > 1]
    found += [f"no {name}" for name in re.findall(r"\\ref\{(tab:\w+)\}", tex) if name not in labels]
    for text in TABLE.findall(tex):
        name = (re.findall(r"\\label\{tab:(\w+)\}", text) or ["a table without a label"])[0]
        head, _, body = text.partition(r"\endfoot")
        if not re.search(r"\\caption\{.+\}\\label\{tab:\w+\}", head):
            found.append(f"{name}: no caption")
        if any(rule not in head for rule in (r"\toprule", r"\midrule", r"\bottomrule")):
            found.append(f"{name}: no booktabs")
        if r"\hline" in text or "|" in text.partition("\n")[0]:
            found.append(f"{name}: lines of its own")
        if name != "messages" and (syntax := SYNTAX.search(body)):
            found.append(f"{name}: program syntax {syntax[0]}")
        if r"\pm" in body and name != "envelopes":
            found.append(f"{name}: an error in the column of values")
    return found


def faults_of_floats(tex: str) -> list[str]:
    """Return the floats that have only one allowed position, or lack a caption.

    [H] is no float: it stands in the text as a paragraph does.
    """
    floats = re.findall(r"\\begin\{figure\}(.*?)\\end\{figure\}", tex, re.DOTALL)
    return [
        text
        for text in floats
        if not text.startswith(("[htbp]", "[H]")) or r"\caption{" not in text
    ]


def faults_of_log(log: str) -> list[str]:
    """Return the lines beyond the margin and the undefined references of a LaTeX log."""
    wide = re.findall(r"Overfull \\hbox \(([\d.]+)pt.*", log)
    found = [f"{points} pt too wide" for points in wide if float(points) > WIDEST]
    return found + re.findall(r"LaTeX Warning: Reference.*undefined.*", log)
