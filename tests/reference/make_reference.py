#!/usr/bin/env python3
"""Writes the references that people read from the sources that programs are made of:

  messages/README.md   every message and field, from messages/*.lcm
  server/config.md     every setting, from config_fields.h, the structs' comments and --print-config
  src/reasons.md       every reason code with what to do, from src/reason.cpp

With --check nothing is written: it fails where a file is not what would be written.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
MADE = "<!-- Made by tests/reference/make_reference.py: change the sources, then run it. -->\n"

CHANNELS = """
| channel | message | who sends it |
|---|---|---|
| `eifmap.CAMERA.calibration` | camera_t | the camera, every second |
| `eifmap.CAMERA.image` | bot_core.image_t | the camera |
| `eifmap.CAMERA.features` | feature_frame_t | the camera, instead of images |
| `eifmap.CAMERA.measurement` | measurement_t | who measures in metres: GPS, odometry |
| `eifmap.CAMERA.pose` | pose_t | the server, one an image |
| `eifmap.CAMERA.map` | map_part_t | the server, one or more a keyframe, and again what is asked for |
| `eifmap.CAMERA.map_request` | map_request_t | who misses parts of the map, or comes late |
| `eifmap.CAMERA.decision` | decision_t | the server, one a pose: what a replay needs |
| `eifmap.CAMERA.status` | status_t | the server, every second and on every change |
| `eifmap.server.status` | status_t | the server, every second, while it maps no camera or refuses one |
| `eifmap.CAMERA.relative_request` | relative_request_t | who wants two keyframes to each other, with their covariance |
| `eifmap.CAMERA.relative` | relative_t | the server, one a request |
| `eifmap.CAMERA.command` | command_t | who commands; CAMERA `server`: all that the server maps |
| `eifmap.CAMERA.reply` | reply_t | the server, one a command, and the same again for the same command |

CAMERA is 1 to 24 characters of `A-Z a-z 0-9 _ -`. Numbers of all types are as LCM encodes them. The
schemas are the contract: a change of one changes its fingerprint, and old and new programs do not
understand each other.

## The published map

A map is sent in updates, each in parts that fit a datagram. Updates are numbered through (`seq`), each
says from which number it leads to which, or that it is the whole map, and the digest of the map that
it leads to. So a client knows what it misses, asks for just that, and knows that its copy is right: a
late or lossy one ends with the map that all others hold. How far the map has come is also in every pose
and status (`map_seq`), and its digest in the status: where the last update was lost, they tell.
[eifmap_client](../client/library/eifmap/map_client.h) does all of this in C++.

**Digest**: the sum modulo 2^64 of the hashes of the map's keyframe_t, landmark_t and observation_t
entries, so that order does not matter. The hash of an entry is FNV-1a (64 bits) of a byte for its kind
(`K`, `L` or `O`) and then its fields as LCM encodes them, without a fingerprint, and then MurmurHash3's
finalizer: `h ^= h >> 33; h *= 0xff51afd7ed558ccd; h ^= h >> 33; h *= 0xc4ceb9fe1a85ec53; h ^= h >> 33`.
An update is taken over in this order: keyframes, removed landmarks (with their observations),
landmarks, observations; those of landmarks that are not in the map are passed over.

## Commands

`eifmap ctl` does this; your own program goes the same way. **Ping** with a new `sender`, `server_epoch` 0
and `ticket` 0, again and again until the reply comes. Its `server_epoch` and `ticket` go into the command
proper, with the next `request_id`; send that, the same bytes, until its reply comes. What can go wrong on
the way then does no harm:

- It comes twice: the server remembers the last 1,024 requests that were done (at most 1 MiB of replies)
  and answers one of them as before, without doing it again.
- It comes late: one that is not above the sender's last is refused (`TOO_OLD`), and so is one whose
  ticket is older than 60 s or than a request that was forgotten. Tickets are of a clock of the server's
  own, so that nobody's clock must be right.
- The server was started again meanwhile: `OTHER_RUN`. Nothing is done over a restart.

**Who may command.** With `secret_file` in the server's configuration, who signs with what is in that
file: `mac` is the HMAC-SHA256 of the whole message encoded without it, so also of who sends, which
request, which run and which ticket. Replies to what was signed are signed, too. The secret does not
encrypt anything: who listens reads commands and replies.

Without one, LCM does not tell who sends, and any machine may send to a multicast group or a port. So
commands are taken only where what the server sends stays on its machine (`udpm://` with ttl 0, `memq://`,
`file://`), else they are refused (`SECRET_WANTED`). There a reply reaches this machine alone; tickets
count from a number that is drawn by chance at the server's start, so that who has not heard a reply cannot
guess one. Every user of this machine may command then; where that is too many, use a secret.
Pings alone are answered to whoever sends them, and change nothing.
"""


def cell(text):
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")


def row(*cells):
    return "| " + " | ".join(cells) + " |\n"


class Commented:
    """Lines of C-like declarations, each with the comment before it or behind it."""

    def __init__(self, text):
        self.text = text
        self.next = []  # the comment of the line of code after the one in hand

    def __iter__(self):
        """(code, comment) of each line of code."""
        before, code, column = [], "", 0
        for line in self.text.splitlines():
            rest, _, comment = line.partition("//")
            if rest.strip():
                if code:
                    yield code, " ".join(before)
                    before = self.next
                self.next = []
                code, column = rest.strip(), len(rest) if comment else -1
                before = before + [comment.strip()] if comment else before
            elif comment and code and len(rest) == column:
                before = before + [comment.strip()]  # goes on below
            else:
                column = -1
                if code:
                    self.next = self.next + [comment.strip()] if comment else []
                else:
                    before = before + [comment.strip()] if comment else []
        if code:
            yield code, " ".join(before)


# --- messages


def message_page():
    page = MADE + "# Messages\n" + CHANNELS
    for file in sorted((ROOT / "messages").glob("*.lcm")):
        text = file.read_text()
        head, _, body = text.partition("{")
        package = re.search(r"package (\w+);", head).group(1)
        about = " ".join(re.findall(r"^// ?(.*)$", head, re.MULTILINE))
        page += f"\n## {package}.{file.stem}\n\n{about}\n\n" if about else \
            f"\n## {package}.{file.stem}\n\n"
        page += row("field", "type", "what") + "|---|---|---|\n"
        constants = []
        for code, comment in Commented(body.partition("}")[0]):
            constant = re.match(r"const \w+ (.*);", code)
            if constant:
                constants += constant.group(1).split(", ")
                continue
            field = re.match(r"(\S+)\s+(\w+)((?:\[\w+\])*);", code)
            page += row(f"`{field.group(2)}`", f"`{field.group(1)}{field.group(3)}`", cell(comment))
        if constants:
            page += "\n" + ", ".join(f"`{constant}`" for constant in constants) + "\n"
    return page


# --- settings


def declarations():
    """{struct: {field: (type, comment)}}, {enum: {enumerator: comment}} of all that is configured."""
    structs, enums = {}, {}
    headers = [ROOT / "server" / "config.h", ROOT / "server" / "inbox.h",
               *sorted((ROOT / "src").rglob("*.h"))]
    for header in headers:
        text = header.read_text()
        for name, body in re.findall(r"^struct (\w+) \{\n(.*?)^\};", text, re.MULTILINE | re.DOTALL):
            fields = structs.setdefault(name, {})
            for code, comment in Commented(body):
                for of, names in re.findall(r"^([\w:<>, ]+) ((?:\w+(?: = [^,;]+|\{\})?(?:, )?)+);$", code):
                    for field in re.findall(r"(\w+)(?: = [^,;]+|\{\})?(?:, |$)", names):
                        fields[field] = (of, comment)
        for name, body in re.findall(r"^enum class (\w+)[^{]*\{\n?(.*?)\};", text,
                                     re.MULTILINE | re.DOTALL):
            enums[name] = {re.match(r"\w+", code).group(): comment
                           for code, comment in Commented(body.replace(", k", ",\nk"))}
    return structs, enums


def visited_fields():
    """{struct: [(name in the file, member)]} of config_fields.h."""
    text = (ROOT / "server" / "config_fields.h").read_text()
    return {name: re.findall(r'visit\("(\w+)", o\.(\w+)\)', body)
            for name, body in re.findall(r"OptionsOf<(\w+)> O>(.*?)^\}", text,
                                         re.MULTILINE | re.DOTALL)}


def names_of_values():
    """{(enum, enumerator): name in the file}."""
    texts = [file.read_text() for folder in ("server", "src", "messages")
             for file in (ROOT / folder).rglob("*.[hc]*") if file.is_file()]
    return {(enum, enumerator): name for text in texts for name, enum, enumerator in
            re.findall(r'std::pair\{"(\w+)",\s*(\w+)::(k\w+)\}', text)}


class SettingsPage:
    def __init__(self, defaults):
        self.defaults = defaults
        self.structs, self.enums = declarations()
        self.visited, self.values = visited_fields(), names_of_values()
        self.bare = []  # settings without a word about them

    def values_text(self, enum):
        texts = []
        for enumerator, comment in self.enums.get(enum, {}).items():
            name = self.values.get((enum, enumerator))
            if name:
                texts.append(f"`{name}`" + (f" ({comment})" if comment else ""))
        return "One of " + ", ".join(texts) if texts else ""

    def section(self, struct, path, defaults):
        rows, below = "", ""
        for name, member in self.visited[struct]:
            of, comment = self.structs[struct][member]
            full = path + name
            inner = re.sub(r"std::optional<(\w+)>", r"\1", of)
            if inner in self.visited:
                below += self.section(inner, full + ".", defaults and defaults[name])
                continue
            default = "" if defaults is None else f"`{json.dumps(defaults[name])}`"
            text = cell(". ".join(filter(None, [comment.rstrip("."), self.values_text(of)])))
            if not comment and of not in self.enums:
                self.bare.append(full)
            rows += row(f"`{full}`", default, text)
        return rows + below

    def page(self):
        return (MADE + "# Settings of eifmap-server\n\n"
                "`eifmap-server --config FILE` takes any part of this as JSON, nested where the "
                "names have dots; `--print-config` shows all of it. Several have an option of "
                "their own on the command line, which goes before the file.\n\n"
                + row("setting", "default", "what") + "|---|---|---|\n"
                + self.section("ServerConfig", "", self.defaults))


def settings_page(server):
    printed = subprocess.run([server, "--print-config"], check=True, capture_output=True, text=True)
    settings = SettingsPage(json.loads(printed.stdout))
    return settings.page(), settings.bare


# --- reasons


def reasons_page():
    codes = dict(re.findall(r"^  (k\w+) = (\d+),", (ROOT / "src" / "reason.h").read_text(),
                            re.MULTILINE))
    text = (ROOT / "src" / "reason.cpp").read_text()
    page = (MADE + "# When something is wrong: the reason codes\n\n"
            "Every pose without a good answer and every status carries one of these, and the status "
            "says it in words, with its numbers and the hint.\n\n"
            + row("code", "name", "what happened", "what to do") + "|---|---|---|---|\n")
    for entry in re.findall(r"ReasonText\{(.*?)\}", text, re.DOTALL):
        reason = re.search(r"Reason::(k\w+)", entry).group(1)
        # Neighbouring literals are one; a comma is between two.
        words = ["".join(re.findall(r'"((?:[^"\\]|\\.)*)"', part))
                 for part in re.findall(r'(?:"(?:[^"\\]|\\.)*"\s*)+', entry)]
        if reason == "kNone":
            continue
        page += row(codes[reason], f"`{words[0]}`", cell(words[1]), cell(words[2]))
    return page


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", default=ROOT / "build/release/bin/eifmap-server")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    settings, bare = settings_page(options.server)
    pages = {"messages/README.md": message_page(), "server/config.md": settings,
             "src/reasons.md": reasons_page()}
    problems = [f"{name}: nothing is said about it where it is declared" for name in bare]
    for name, page in pages.items():
        file = ROOT / name
        if not options.check:
            file.write_text(page)
        elif not file.exists() or file.read_text() != page:
            problems.append(f"{name} is not what its sources say: run make_reference.py")
    if problems:
        sys.exit("FAILED: " + "\n".join(problems))


main()
