"""How the page looks."""

STYLE = """
body, #main, #content { background: #f3f5f7; }
:host(.panel) {
  background: #ffffff; border: 1px solid #dde3e9; border-radius: 8px;
  padding: 6px 4px 10px 4px; margin: 6px 10px 10px 10px;
}
"""

TEXTS_STYLE = """
:host { font: 14px/1.45 system-ui, sans-serif; color: #22303c; }
h2 { font-size: 15px; font-weight: 600; margin: 4px 0 0 0; }
h3 { font-size: 13px; font-weight: 600; margin: 4px 0 0 0; border-bottom: 1px solid #dde3e9; }
code { font-size: 13px; }
.tiles { display: flex; flex-wrap: wrap; gap: 12px; }
.tile {
  flex: 1 1 170px; background: #ffffff; border: 1px solid #dde3e9; border-radius: 8px;
  padding: 10px 14px;
}
.what { color: #5a6b7b; font-size: 13px; }
.value { font-size: 24px; font-weight: 600; }
.hint { color: #5a6b7b; font-size: 12px; }
.refusal {
  background: #fdecea; color: #8c1d18; border: 1px solid #f2b8b5; border-radius: 8px;
  padding: 10px 14px; margin: 0 0 8px 0; overflow-wrap: anywhere;
}
:host(.status) { color: #5a6b7b; font-size: 13px; }
:host(.running) { color: #0072b2; font-weight: 600; }
:host(.refused) { color: #8c1d18; }
:host(.formula), :host(.equation) { overflow-x: auto; }
math { font-size: 17px; margin: 6px 0; }
"""
