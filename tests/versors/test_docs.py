"""The examples of docs/algebra.md run as printed."""

import doctest
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "algebra.md"


def test_examples_of_the_page():
    text = PAGE.read_text(encoding="utf-8").replace("```", "")
    examples = doctest.DocTestParser().get_doctest(text, {}, "algebra.md", str(PAGE), 0)
    assert len(examples.examples) > 10
    failures = []
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    runner.run(examples, out=failures.append)
    assert runner.failures == 0, "".join(failures)
