#!/usr/bin/env python3
"""Tests of the checker of words and of reflowing: planted offences are found, sound text is left
alone, words stay.

Usage: self_check.py [unittest's options]
"""

import contextlib
import io
import pathlib
import random
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import check  # noqa: E402
import reflow  # noqa: E402
import sentences  # noqa: E402
import text_blocks  # noqa: E402

# For each record of patterns.txt: an offence, and a text that is no offence.
CASES = {
    "Of (?!course)": ("Of the worst pixels, so few are left out.", "Of course none is lost."),
    r"What\b": ("What is to be made small.", "Whatever the seed, the mean of all runs."),
    "That (?!is,)": ("That of the light.", "That is, the mean."),
    r"Those\b": ("Those that were met.", "Thoseby's estimator."),
    r"Such\b": ("Such a vertex.", "Suchard's estimator."),
    r"As (?!(a|an|the)? ?(default|above)\b)": ("As by default, but for the numbers.", "As a default, one light tree."),
    r"By (?!default\b)": ("By region the counts.", "By default one light tree."),
    r"(Which|Whose)\b": ("Which light is meant.", "Index of the light that was chosen."),
    r"(The same (for|of|with|where|after|in|at|as|but|when)\b|The same,|Likewise)": ("The same for a batch.", "The same seed gives the same bits."),
    r"\bso many\b": ("one of every so many", "one of N"),
    r"\bas many as\b": ("as many as it says", "one for each light"),
    r"\bthe same of\b": ("the same of the camera", "the same bits"),
    r"\bin vain\b": ("named in vain", "an invariant"),
    r"\blest\b": ("lest it decides", "the fullest cell"),
    r"\bat the (most|least)\b": ("0.9 at the most", "0.9 at most"),
    r"\b(Of|of) (what|that which)\b": ("a bound of what is left", "a bound of the rest"),
    "(?<=[.;:] )(Of|Such|Those|That of) (?!course)": ("It ends. Such paths are rare.", "It ends. Suchard proved it; of these two remain."),
    r"\bof (that|those) of\b": ("an eighth of that of the other", "an eighth of that figure"),
    r"\bof (theirs|ours|one's own)\b": ("pictures of theirs", "pictures of the others"),
}


def findings_in(name, text):
    checker = check.Checker(check.read_patterns())
    checker.file(pathlib.Path(name), name, text)
    return checker.findings


def lines(*rows):
    return "\n".join(rows) + "\n"


LONG = "word " * 24  # 120 characters


class Patterns(unittest.TestCase):
    def test_each_record_finds_its_offence_and_no_sound_text(self):
        patterns = check.read_patterns()
        self.assertEqual([p.text for p in patterns], list(CASES))
        for pattern in patterns:
            offence, sound = CASES[pattern.text]
            with self.subTest(pattern.text):
                kind = ("opening " if pattern.where == "docstring" else "phrase ") + pattern.text
                self.assertIn(kind, [f[2] for f in findings_in("a.hpp", f"/// {offence}\nint a;\n")])
                self.assertNotIn(kind, [f[2] for f in findings_in("a.hpp", f"/// {sound}\nint a;\n")])

    def test_prose_is_read_in_comments_messages_and_markdown(self):
        for name, text in (
            ("a.cpp", "// one of every so many\n"),
            ("a.cpp", "int a;  // one of every so\n"),
            ("a.cpp", "int a;  // one of every so many\n"),
            ("a.cpp", 'throw E("one of every so many");\n'),
            ("a.cpp", "// one of every so\n// many\n"),
            ("a.py", '"""One of every so many."""\n'),
            ("a.py", "a = 1  # one of every so many\n"),
            ("CMakeLists.txt", "# one of every so many\n"),
            ("a.md", "One of every so many.\n"),
        ):
            with self.subTest(text):
                expected = 0 if text.endswith("every so\n") else 1
                self.assertEqual(sum("so many" in f[2] for f in findings_in(name, text)), expected)

    def test_code_is_not_prose(self):
        for name, text in (
            ("a.md", "A name: `so many`.\n"),
            ("a.md", "```cpp\n// so many\n```\n"),
            ("a.cpp", "int so, many;  // two numbers\n"),
        ):
            with self.subTest(text):
                self.assertEqual(findings_in(name, text), [])

    def test_the_line_is_named(self):
        found = findings_in("a.hpp", "int a;\n\n/// First.\n/// One of every so\n/// many.\nint b;\n")
        self.assertEqual([f[1] for f in found], [4])

    def test_docstrings_of_members_and_files(self):
        self.assertEqual(len(findings_in("a.hpp", "int a;  ///< What is left.\n")), 1)
        self.assertEqual(len(findings_in("a.hpp", "/// \\file\n/// What is left.\n")), 1)
        self.assertEqual(len(findings_in("a.hpp", "// What follows is long.\nint a;\n")), 0)


class Widths(unittest.TestCase):
    def test_limits(self):
        wide = "// " + "word " * 19
        self.assertEqual(findings_in("a.cpp", wide + "ab\n"), [])  # 100
        self.assertEqual([f[2] for f in findings_in("a.cpp", wide + "abc\n")], ["width of comments"])  # 101
        code = "int a;" + " " * 60 + "// " + "word " * 10
        self.assertEqual(findings_in("a.cpp", code + "x\n"), [])
        self.assertEqual([f[2] for f in findings_in("a.cpp", code + "xx\n")], ["width of code"])

    def test_a_long_address_cannot_be_broken(self):
        self.assertEqual(findings_in("a.cpp", "// https://example.org/" + "a" * 100 + "\n"), [])

    def test_strings_with_slashes_are_no_comments(self):
        self.assertEqual(findings_in("a.cpp", 'auto a = "https://' + "a " * 55 + '";\n'), [])
        self.assertEqual(findings_in("a.cpp", 'auto a = R"(\n// ' + "a " * 60 + '\n)";\n'), [])
        self.assertEqual(findings_in("a.cpp", "auto a = 1'000; auto b = '\"'; // short\n"), [])


class CommitSubjects(unittest.TestCase):
    def subjects(self, subject):
        checker = check.Checker([])
        checker.subject("commit", subject)
        return len(checker.findings)

    def test_subjects(self):
        self.assertEqual(self.subjects("faults: move the interrupted-estimate fault to its test"), 0)
        self.assertEqual(self.subjects("mis, bench/run: time a scheme"), 0)
        self.assertEqual(self.subjects("Planted faults: the interrupted estimate is another test's"), 1)
        self.assertEqual(self.subjects("no area"), 1)
        self.assertEqual(self.subjects("run: " + "a" * 67), 0)
        self.assertEqual(self.subjects("run: " + "a" * 68), 1)


class Wrapping(unittest.TestCase):
    def check_wrap(self, text, expected, name="a.hpp"):
        new = reflow.reflowed(pathlib.Path(name), text)
        self.assertEqual(new, expected)
        self.assertEqual(reflow.reflowed(pathlib.Path(name), new), new)

    def kept(self, text, name="a.hpp"):
        self.check_wrap(text, text, name)

    def test_a_long_paragraph_is_filled(self):
        rest = "word " * 5
        self.check_wrap(
            f"/// {LONG}\n/// end.\nint a;\n",
            f"/// {('word ' * 19).strip()}\n/// {rest}end.\nint a;\n",
        )

    def test_a_short_paragraph_keeps_its_lines(self):
        self.kept("// one\n// two\n//\n// three\n")

    def test_rules_are_cut(self):
        self.check_wrap("// --- Title " + "-" * 100 + "\nint a;\n", "// --- Title " + "-" * 87 + "\nint a;\n")
        self.kept("// --- Title ---\n")

    def test_lists_hang(self):
        self.check_wrap(
            f"// - {LONG}\n//   end.\n// - next\n",
            f"// - {('word ' * 19).strip()}\n//   {'word ' * 5}end.\n// - next\n",
        )

    def test_what_keeps_its_lines(self):
        for text in (
            f"// | {LONG} | table |\n",
            f"// ```\n// {LONG}\n// ```\n",
            f"/// @code\n/// {LONG}\n/// @endcode\n",
            f"/// \\file {LONG}\n",
            f"//     {LONG}\n// text\n",
            f"// a    b    {LONG}\n",
            f"int a;  // {LONG}\n",
            f"int a;  // one\n        // {LONG}\n",
            f"// clang-format off {LONG}\n",
            f"#define A \\\n// {LONG} \\\n  b\n",
            f'auto a = R"(\n// {LONG}\n)";\n',
        ):
            with self.subTest(text):
                self.kept(text)

    def test_no_line_begins_like_a_list(self):
        filler = "word " * 19  # 95 characters, so that the next word would begin a line
        for mark in ("-", "1.", "#", "|", "+", "\\file"):
            with self.subTest(mark):
                new = reflow.reflowed(pathlib.Path("a.hpp"), f"// {filler}{mark} word word word\n")
                self.assertFalse(any(line.startswith(f"// {mark}") for line in new.split("\n")), new)

    def test_code_spans_stay_whole(self):
        new = reflow.reflowed(pathlib.Path("a.hpp"), f"// {'word ' * 16}`gmis::Render run`, and more words\n")
        self.assertIn("`gmis::Render run`", new)

    def test_docstrings_of_python(self):
        self.check_wrap(
            f'"""{LONG}end."""\n',
            f'"""{("word " * 19).strip()}\n{"word " * 5}end."""\n',
            "a.py",
        )
        self.check_wrap(
            f'def f():\n    """First.\n\n    {LONG}\n    """\n',
            f'def f():\n    """First.\n\n    {("word " * 19).strip()}\n    {("word " * 5).strip()}\n    """\n',
            "a.py",
        )

    def test_usage_lines_stand_alone(self):
        new = reflow.reflowed(pathlib.Path("a.cpp"), f"// {LONG}\n// Usage: PROGRAM FILE\n")
        self.assertIn("\n// Usage: PROGRAM FILE\n", new)


class Markdown(unittest.TestCase):
    def check_page(self, text, expected):
        new = sentences.one_sentence_a_line(text)
        self.assertEqual(new, expected)
        self.assertEqual(sentences.one_sentence_a_line(new), new)

    def kept(self, text):
        self.check_page(text, text)

    def test_paragraphs(self):
        self.check_page("One sentence\nover lines. Another\none.\n", "One sentence over lines.\nAnother one.\n")

    def test_where_sentences_do_not_end(self):
        for text in (
            "See e.g. Veach.\n",
            "A value of 0.5 and `a. B` too.\n",
            "By Fig. 3 and eq. 4 of Liu et al. 2016.\n",
            "A pair (see Veach. He knows) stays.\n",
            "In [0, 1) it is 0.\n",
            "A formula $a. B$ stays.\n",
            "The member gmis.hpp has it; x.y is one. f is not.\n",
        ):
            with self.subTest(text):
                self.kept(text)

    def test_where_sentences_end(self):
        for text in (
            "It is 3.\nThen 4.\n",
            "In [0, 1) it ends.\n(Another one.)\nA third.\n",
            "It ends!\nDoes it?\n`Yes`.\n[It](a.md) does.\n**Bold.** Text.\n",
            "Unmatched ( here.\nNext.\n",
        ):
            with self.subTest(text):
                self.check_page(text.replace("\n", " ").strip() + "\n", text)

    def test_lists(self):
        self.check_page(
            "- One. Two\n  three.\n- Four\nlazy.\n\n1. Five. Six.\n   - Seven. Eight.\n\n   Nine. Ten.\n",
            "- One.\n  Two three.\n- Four lazy.\n\n1. Five.\n   Six.\n   - Seven.\n     Eight.\n\n   Nine.\n   Ten.\n",
        )

    def test_what_keeps_its_lines(self):
        for text in (
            "```cpp\nOne. Two.\nthree\n```\n",
            "~~~\nOne. Two.\n~~~\n",
            "| a. B | c |\n| --- | --- |\n| One. Two | d |\n",
            "# One. Two\n",
            "> One. Two.\n> Three.\n",
            "<!-- One. Two.\nThree. Four. -->\n",
            "<p>One. Two.\nThree.</p>\n",
            "$$\na. B\n$$\n",
            "[name]: https://example.org\n",
            "A heading\n=========\n",
            "para\n\n    code. Here\n    more\n",
            "---\nname: A. B\nabout: c\n---\n",
            "A forced  \nbreak.\n",
            "---\n",
        ):
            with self.subTest(text):
                self.kept(text)

    def test_wrapped_paragraphs_are_found(self):
        found = findings_in("a.md", "Fine.\n\nWrapped over\nlines.\n")
        self.assertEqual([(f[1], f[2]) for f in found], [(3, "Markdown lines")])


class Project(unittest.TestCase):
    def test_words_of_the_project_stay(self):
        """Reflows every file of the project: the same words in the same order, and nothing left to
        do."""
        for path in reflow.project_files():
            text = path.read_text(encoding="utf-8")
            new = reflow.reflowed(path, text)
            with self.subTest(str(path)):
                self.assertEqual(reflow.words_of(path, new), reflow.words_of(path, text))
                self.assertEqual(reflow.reflowed(path, new), new)

    def test_words_of_random_texts_stay(self):
        pieces = ["word", "a.", "B", "`x y`", "(p", "q)", "-", "1.", "|", "[l](t.md)", "$a$", "\n", "\n", "\n\n", "  ", "- ", "# ", "e.g.", "**b.**"]
        generator = random.Random(1)
        for _ in range(3000):
            words = [generator.choice(pieces) for _ in range(generator.randrange(60))]
            page = " ".join(words)
            new = sentences.one_sentence_a_line(page)
            self.assertEqual(new.split(), page.split(), page)
            self.assertEqual(sentences.one_sentence_a_line(new), new, page)
            comment = "\n".join("// " + line for line in page.split("\n"))
            path = pathlib.Path("a.hpp")
            new = reflow.reflowed(path, comment)
            self.assertEqual(reflow.words_of(path, new), reflow.words_of(path, comment), comment)
            self.assertEqual(reflow.reflowed(path, new), new, comment)


class Program(unittest.TestCase):
    def test_exit_status_and_counts(self):
        with tempfile.TemporaryDirectory() as folder:
            bad, good = pathlib.Path(folder, "bad.hpp"), pathlib.Path(folder, "good.hpp")
            bad.write_text("/// What is left.\nint a;\n")
            good.write_text("/// Rest of the sum.\nint a;\n")
            output = io.StringIO()
            with contextlib.redirect_stdout(output):
                self.assertEqual(check.main([str(good)]), 0)
                self.assertEqual(check.main([str(bad)]), 1)
            self.assertIn("bad.hpp:1: ", output.getvalue())
            self.assertIn("1  in all", output.getvalue())
            subject = pathlib.Path(folder, "message")
            subject.write_text("run: format words, too\n\nWhat follows is not read.\n")
            with contextlib.redirect_stdout(output):
                self.assertEqual(check.main(["--subject", str(subject)]), 0)


if __name__ == "__main__":
    unittest.main()
