"""One run of the real programs over a recording made worse, and what it came to."""
import json
import pathlib
import subprocess


class Programs:
    """degrade, eifmap-server and eifmap eval, in one folder."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)

    def call(self, name, *arguments):
        """Its standard output. RuntimeError with what it said when it fails."""
        command = [str(word) for word in (self.folder / name, *arguments)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)} ended with {done.returncode}:\n{done.stderr}")
        return done.stdout

    def map(self, folder, output, *options):
        """The report. Maps also where not one pose comes of it."""
        self.call("eifmap-server", "--sequence", folder, "--output", output, *options)
        return json.loads((output / "report.json").read_text())

    def error_m(self, truth, trajectory):
        """RMSE after a similarity transform; None where too few poses match."""
        command = [self.folder / "eifmap", "eval", "--gt", truth, "--est", trajectory, "--json"]
        done = subprocess.run(command, capture_output=True, text=True)
        return json.loads(done.stdout).get("ate_rmse_m") if done.returncode == 0 else None
