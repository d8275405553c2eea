#!/usr/bin/env python3
"""The table says what the runs came to."""
import argparse
import unittest

from table import BEGIN, END, Outcome, Row, coverage_cell, error_cell, explanation, page_with_tables, table


class Cells(unittest.TestCase):
    def test_mean_and_worst_error(self):
        self.assertEqual(error_cell([Outcome(0.1, 1), Outcome(0.3, 0.9)]), "0.200 / 0.300")

    def test_lost_runs_are_seen_and_not_averaged(self):
        lost = Outcome(0.001, 0.05)
        self.assertEqual(error_cell([Outcome(0.1, 1), lost]), "0.100 / **lost** 1 of 2")
        self.assertEqual(error_cell([lost, Outcome(None, 0)]), "**lost**")

    def test_no_truth_is_no_error(self):
        self.assertEqual(error_cell([Outcome(None, 1)]), "-")

    def test_least_coverage_rounded_down(self):
        self.assertEqual(coverage_cell([Outcome(1, 1), Outcome(1, 0.9999)]), "0.999")
        self.assertEqual(coverage_cell([Outcome(1, 1)]), "1.000")


class Page(unittest.TestCase):
    def test_a_row_of_each_degradation(self):
        rows = [Row("a\t0\tthis"), Row("b\t1\tthat")]
        self.assertEqual((rows[0].seeded, rows[1].seeded), (False, True))
        text = table(rows, [("place", [[Outcome(1, 1)], [Outcome(2, 0.5)]])])
        self.assertEqual(text, "| | place: error (m), mean / worst | coverage |\n|---|---:|---:|\n"
                               "| this | 1.000 / 1.000 | 1.000 |\n| that | 2.000 / 2.000 | 0.500 |\n")

    def test_what_was_skipped(self):
        options = argparse.Namespace(seeds=5)
        self.assertIn("nowhere: skipped", explanation(options, ["nowhere"]))
        self.assertNotIn("skipped", explanation(options, []))

    def test_what_is_written_by_hand_stays(self):
        page = "Before.\n" + page_with_tables("", "old tables\n") + "After.\n"
        self.assertEqual(page_with_tables(page, "new tables\n"), page.replace("old", "new"))
        for broken in ("by hand alone", END + BEGIN, BEGIN):
            with self.assertRaises(SystemExit):
                page_with_tables(broken, "tables")


unittest.main()
