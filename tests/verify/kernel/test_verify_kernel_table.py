"""The table of rules: complete, in its order, and entered from nowhere else."""

import ast
from pathlib import Path

import longwave.verify.kernel as kernel
from longwave.verify.kernel.axioms import FUNCTIONS
from longwave.verify.kernel.field import Rule, Rules
from longwave.verify.kernel.table import RULES

FOLDER = Path(kernel.__file__).parent

QUESTIONS = ("image", "relation", "branch", "continuity", "equation")


def names(question: str, function: str) -> list[str]:
    return [answer.__name__ for answer in RULES.tried(question, function)]


def test_each_rule_states_what_it_assumes() -> None:
    for row in RULES.rows:
        assert row.question in QUESTIONS, row
        assert len(row.assumes) > 10, row
        assert row.functions, row


def test_rules_are_of_functions_that_have_axioms() -> None:
    for row in RULES.rows:
        assert {*row.functions} <= {*FUNCTIONS, "Pow", "="}, row


def test_the_order_in_which_exponentials_are_tried() -> None:
    """Catches: a rule moved before another that answers differently."""
    special = ["exponential_of_lambert", "phase_of_arctangent", "turns_of_integer"]
    assert names("image", "exp") == [*special, "root_of_unity", "exponential"]
    assert names("image", "jacobi_sn") == ["at_end", "elliptic"]
    assert names("image", "jacobi_zeta") == ["elliptic"]
    assert names("branch", "Pow") == ["is_not_negative", "is_multiple", "is_principal"]


def test_every_rule_of_the_rule_files_is_in_the_table() -> None:
    """Catches: a public function of a rule file that no row and no other rule uses."""
    used = {row.answer.__name__ for row in RULES.rows}
    helpers = {"whole", "angle_of", "real_part", "is_branch", "turn_of", "fraction_of_turn"}
    helpers |= {"is_value", "is_convex", "is_continuous"}
    for path in FOLDER.glob("*_rules.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        own = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
        assert {name for name in own if name[0] != "_"} <= used | helpers, path


def test_no_table_changes_after_its_file() -> None:
    """Catches: a registration by import, as a table that another module adds to."""
    for path in FOLDER.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.AugAssign | ast.Assign):
                target = node.target if isinstance(node, ast.AugAssign) else node.targets[0]
                base = target.value if isinstance(target, ast.Subscript) else target
                added = isinstance(node, ast.AugAssign) or isinstance(target, ast.Subscript)
                assert not (added and isinstance(base, ast.Name) and base.id.isupper()), path


def test_rules_are_tried_in_the_order_of_the_rows() -> None:
    first, second = (lambda *_: 1), (lambda *_: 2)
    rules = Rules(Rule("image", ("f", "g"), first, ""), Rule("image", ("g",), second, ""))
    assert list(rules.tried("image", "g")) == [first, second]
    assert list(rules.tried("image", "f")) == [first]
    assert list(rules.tried("relation", "f")) == []
