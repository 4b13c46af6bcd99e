"""The API documentation builds without a warning, one page a module."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = ("environments/hhrl_envs", "agents/hhrl_agents", "hhrl_bench")


def test_every_module_has_a_page_and_nothing_is_warned_of(tmp_path: Path) -> None:
    command = [sys.executable, str(ROOT / "docs" / "api.py"), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    sources = [path for package in PACKAGES for path in (ROOT / package).glob("*.py")]
    modules = {f"{path.parent.name}/{path.stem}.html" for path in sources if not path.stem.startswith("__")}
    packages = {f"{Path(package).name}.html" for package in PACKAGES}
    pages = {page.relative_to(tmp_path).as_posix() for page in tmp_path.rglob("*.html")}
    assert pages == modules | packages | {"index.html"}
    for page in pages - {"index.html"}:
        assert 'class="docstring"' in (tmp_path / page).read_text(), page
