"""The HTML report: complete, escaped, loading nothing, equal for equal leaderboards."""

import importlib.util
from pathlib import Path

import pytest

from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.entry import write_entry
from hhrl_bench.leaderboard.record import LeaderboardRecord, compared_to_best
from hhrl_bench.paper_table import TABLE_I
from hhrl_bench.publishing.html_page import LARGEST_SVG, html
from hhrl_bench.tables.comparisons import comparison_tables
from hhrl_bench.tables.learning import efficiency_table, outcome_tables
from hhrl_bench.tables.results import further_tables, results_table, runs_table, sensitivity_tables
from hhrl_bench.tables.transfers import transfer_tables
from hhrl_bench.text import NONE
from support.command_line import invoke
from support.pages import Page
from support.whole_board import AGENTS, whole_board

HOSTILE = (
    "</th></table><img src=http://a.example/x onerror=alert(1)><script>alert(2)</script>",
    "../../\"'><svg/onload=alert(1)> {{ 7 * 7 }}{% raw %} &lt;b&gt; &amp; $\\frac$ \N{CJK UNIFIED IDEOGRAPH-4E2D}",
    "x" * 500,
)
LOADING = {"src", "href", "xlink:href", "srcset", "poster", "data", "action", "background"}


def page_of(board: LeaderboardRecord) -> str:
    return html(board, Store(Path("unused")))


@pytest.fixture(scope="module")
def board() -> LeaderboardRecord:
    return whole_board()


@pytest.fixture(scope="module")
def text(board: LeaderboardRecord) -> str:
    return page_of(board)


@pytest.fixture(scope="module")
def page(text: str) -> Page:
    return Page(text)


def test_every_number_of_every_table_is_on_the_page(board: LeaderboardRecord, page: Page) -> None:
    assert board.transfer is not None
    for task in board.tasks:
        results, compared = board.on(task), compared_to_best(board, task)
        tables = [results_table(task, results, seeds=True), *further_tables(task, results), runs_table(results)]
        tables += [*sensitivity_tables(board.sensitivity, task), *comparison_tables(compared)]
        tables += [efficiency_table(board.efficiency)]
        tables += [*outcome_tables(board.trainings), *transfer_tables(board.transfer.rows)]
        for table in (table for table in tables if table.groups):
            assert [table.names, *(column.line for column in table.columns)] in page.rows
            for row in (row for group in table.groups for row in group.rows):
                said = [(cell.value or NONE) + (f" {cell.bounds}" if cell.bounds else "") for cell in row.cells]
                assert [row.name, *said] in page.rows


def test_a_result_stands_with_its_intervals_and_without_the_papers_rows(board: LeaderboardRecord, page: Page) -> None:
    success = board.results[1].metrics.success
    assert success.mean is not None
    row = next(row for row in page.rows if row[0] == "rule-2" and len(row) == 12)
    assert row[9].startswith(f"{success.mean:.1%} ")
    assert not {row.policy for row in TABLE_I} & {row[0] for row in page.rows}, "these tasks are not of its world"


def test_tasks_agents_settings_and_provenance_are_named(board: LeaderboardRecord, page: Page) -> None:
    made = board.provenance
    said = [*AGENTS, *(task.id for task in board.tasks), *(task.golden_digest for task in board.tasks)]
    said += [made.command, made.created, made.hardware.machine, *made.versions.values(), *made.wall_seconds]
    said += ["net.hidden [64, 32]", "rate 0.125", "config hash abc"]
    for text in said:
        assert text in page.text


def test_figures_are_on_the_page(page: Page) -> None:
    images = [attributes for tag, attributes in page.tags if tag == "img"]
    assert len(images) >= 3
    for image in images:
        assert str(image["src"]).startswith(("data:image/svg+xml;base64,", "data:image/png;base64,"))
        assert image["alt"]


def test_the_page_loads_and_runs_nothing(page: Page) -> None:
    assert not {"script", "link", "iframe", "object", "embed", "base", "form"} & {tag for tag, _ in page.tags}
    for _, attributes in page.tags:
        assert not [name for name in attributes if name.startswith("on")]
        for name in LOADING & set(attributes):
            assert str(attributes[name]).startswith("data:image/")
    policy = next(a["content"] for tag, a in page.tags if a.get("http-equiv") == "Content-Security-Policy")
    assert str(policy).startswith("default-src 'none';")


@pytest.mark.parametrize("name", HOSTILE)
def test_names_are_text_whatever_they_hold(page: Page, name: str) -> None:
    spoilt = Page(page_of(whole_board(name)))
    kinds = {tag for tag, _ in page.tags}
    assert {tag for tag, _ in spoilt.tags} <= kinds
    assert len(spoilt.rows) == len(page.rows)
    assert " ".join(name.split()) in spoilt.text
    assert name in {row[0] for row in spoilt.rows}


def test_equal_leaderboards_give_equal_bytes(board: LeaderboardRecord, text: str) -> None:
    assert page_of(LeaderboardRecord.model_validate_json(board.model_dump_json())) == text


def test_a_leaderboard_without_learning_has_no_empty_sections(board: LeaderboardRecord) -> None:
    none = {"trainings": (), "trainings_sha256": (), "efficiency": (), "transfer": None, "methods": ()}
    bare = Page(page_of(board.model_copy(update=none)))
    assert "Learning" not in bare.text
    assert "Settings" not in bare.text


def test_a_large_figure_becomes_a_small_picture(board: LeaderboardRecord, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hhrl_bench.publishing.html_page.LARGEST_SVG", 0)
    sources = [str(attributes["src"]) for tag, attributes in Page(page_of(board)).tags if tag == "img"]
    assert sources
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    assert max(map(len, sources)) < 2 * LARGEST_SVG


@pytest.mark.parametrize(("out", "page"), [([], "a.html"), (["--out", "new/b.html"], "new/b.html")])
def test_the_command_writes_the_page(
    board: LeaderboardRecord, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, out: list[str], page: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("hhrl_bench.publishing.html_page.html", lambda board, store, _: f"{board.suite} {store.folder}")
    write_entry(board, Path("a.json"))
    assert invoke("report", "a.json", *out).exit_code == 0
    assert Path(page).read_text() == f"{board.suite} ."


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["missing.json"], "cannot read missing.json"),
        (["spoilt.json"], "spoilt.json is no leaderboard"),
        (["a.json", "--out", "."], "cannot write .: it is not a file"),
        (["a.json", "--out", "a.json/b.html"], "cannot write a.json/b.html"),
        (["a.json", "--out", "./a.json"], "it is the leaderboard; name another --out"),
    ],
)
def test_bad_input_is_one_line_and_leaves_everything(
    board: LeaderboardRecord, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    write_entry(board, Path("a.json"))
    Path("spoilt.json").write_text("{}")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    result = invoke("report", *arguments)
    assert (result.exit_code, result.stdout) == (2, "")
    assert said in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.parametrize("module", ["jinja2", "matplotlib"])
def test_the_extra_is_named_where_it_is_missing(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr("hhrl_envs.errors.find_spec", lambda name: None if name == module else find(name))
    result = invoke("report", "a.json")
    assert (result.exit_code, f"{module} is not installed" in result.stderr) == (2, True)
    assert "pip install -e '.[report]'" in result.stderr
