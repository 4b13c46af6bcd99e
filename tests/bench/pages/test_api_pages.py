"""The API documentation builds without a warning, one page a module."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]
PACKAGES = ("environments/hhrl_envs", "agents/hhrl_agents", "hhrl_bench")


def test_every_module_has_a_page_and_nothing_is_warned_of(tmp_path: Path) -> None:
    command = [sys.executable, str(ROOT / "docs" / "api.py"), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    sources = [path for package in PACKAGES for path in (ROOT / package).rglob("*.py") if path.stem != "__main__"]
    parts = [(path.parent if path.stem == "__init__" else path.with_suffix("")).parts for path in sources]
    tops = {Path(package).name for package in PACKAGES}
    expected = {"/".join(one[next(i for i, part in enumerate(one) if part in tops) :]) + ".html" for one in parts}
    pages = {page.relative_to(tmp_path).as_posix() for page in tmp_path.rglob("*.html")}
    assert pages == expected | {"index.html"}
    for page in pages - {"index.html"}:
        assert 'class="docstring"' in (tmp_path / page).read_text(), page
