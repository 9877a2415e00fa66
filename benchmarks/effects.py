"""Cost of each effect of a chain on a bench (`longwave.reports.studies.effects`), a line each.

python benchmarks/effects.py
"""

from longwave.reports.studies.effects import TOLERANCES, effect_cost, effects


def main() -> None:
    """Print a line for each effect."""
    to = "".join(f"   to {tolerance:g}" for tolerance in TOLERANCES)
    print(f"effect                   ns a cell and stage   operations   share of the core's{to}")
    for name in effects():
        cost = effect_cost(name)
        each, share = f"{cost.seconds * 1e9:12.3f} {cost.operations:17d}", f"{cost.share:18.0%}"
        print(f"{name:24}{each}{share}", *(f"{taken * 1e3:7.0f} ms" for _, taken in cost.runs))


if __name__ == "__main__":
    main()
