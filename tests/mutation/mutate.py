"""Mutation run: shows whether the tests can fail.

Changes one spot in each of 200 functions of engine and render, chosen by lot: a sign, a factor, a bound, a condition, a dropped term. All
changes are compiled into one tree and switched by the environment variable WHORL_MUTANT. A first run of each test records which changes it
reaches. Then each change runs only tests that reach it, until one fails.

    python3 tests/mutation/mutate.py make build/mutants
    cd build/mutants && cmake --preset release && cmake --build --preset release -- -k 0
    python3 tests/mutation/mutate.py run build/mutants --seconds 5
    python3 tests/mutation/mutate.py table build/mutants

Changes that do not compile: repeat `make` with --drop 3,17 (their numbers are in the error message), which replaces them. `run` continues
where it was stopped and uses tests of up to --seconds; a larger number gives the living changes more tests. Tests labelled long need --long.
Only .cpp files are changed, so the tests need no new compilation; constants of compile time, tolerances (1e-6) and subscripts are left out.
"""

import argparse, csv, json, os, random, re, resource, shutil, signal, subprocess, sys, tempfile, threading, time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HEADER = """#pragma once
// The change that this process makes: a number, 0 for none, -1 to record which ones are reached.
#pragma GCC diagnostic ignored "-Wsign-compare"
#pragma GCC diagnostic ignored "-Wparentheses"
#pragma GCC diagnostic ignored "-Wbool-operation"
#pragma GCC diagnostic ignored "-Wint-in-bool-context"
namespace whorl_mutants {
extern const int active;
bool reached(int id);
inline bool on(int id) { return active == id || (active < 0 && reached(id)); }
inline int either(int id, int changed, int original) { return on(id) ? changed : original; }
template <class T>
T min(int id, const T& a, const T& b) { return on(id) == (a < b) ? b : a; }
template <class T>
T max(int id, const T& a, const T& b) { return on(id) == (a < b) ? a : b; }
}
"""
SOURCE = """#include "engine/core/mutants.h"
#include <fcntl.h>
#include <unistd.h>
#include <atomic>
#include <cstdlib>
#include <string>
namespace whorl_mutants {
const int active = std::getenv("WHORL_MUTANT") ? std::atoi(std::getenv("WHORL_MUTANT")) : 0;
__attribute__((cold, noinline)) bool reached(int id) {
    static std::atomic<bool> seen[COUNT];
    if (seen[id].load(std::memory_order_relaxed) || seen[id].exchange(true)) return false;
    const char* path = std::getenv("WHORL_REACHED");
    const int file = path ? open(path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0644) : -1;
    const std::string line = std::to_string(id) + "\\n";
    if (file >= 0 && write(file, line.data(), line.size()) >= 0) close(file);
    return false;
}
}
"""
TOKEN = re.compile(r'[A-Za-z_]\w*|\.?\d(?:[eE][+-]|[\w.\'])*|"+|->|\+\+|--|<<=|>>=|<=>|[-+*/%<>=!&|^]=|&&|\|\||::|<<|>>|\S')


def blank(text):
    """The text without comments, contents of strings and directives, at the same offsets."""
    def cover(match):
        fill = '"' if match[0][0] in "\"'R" else " "
        return re.sub(r"[^\n]", fill, match[0])
    return re.sub(r'R"(\w*)\((?:.|\n)*?\)\1"|//[^\n]*|/\*(?:.|\n)*?\*/|"(?:\\.|[^"\\\n])*"|(?<![\w])\'(?:\\.|[^\'\\\n])+\'|^[ ]*#(?:\\\n|[^\n])*',
                  cover, text, flags=re.M)


def functions(text):
    """Name, tokens of the body and offset of each function of a blanked text."""
    tokens = list(TOKEN.finditer(text))
    scopes, head, i = [], [], 0
    while i < len(tokens):
        word = tokens[i][0]
        if word == "{":
            words = [t[0] for t in head]
            if "namespace" in words or ({"class", "struct"} & set(words) and "(" not in words):
                scopes.append(word)
            else:
                depth, first = 1, i + 1
                while depth:
                    i += 1
                    depth += {"{": 1, "}": -1}.get(tokens[i][0], 0)
                constant = {"constexpr", "consteval", "enum", "=", "union"} & set(words) and "operator" not in words
                if "(" in words and not constant:
                    name = words[words.index("(") - 1] if "operator" not in words else "operator" + words[words.index("operator") + 1]
                    owner = words[words.index("(") - 3] + "::" if words[max(words.index("(") - 2, 0)] == "::" else ""
                    yield owner + name, tokens[first:i]
            head = []
        elif word in ";}":
            if word == "}" and scopes:
                scopes.pop()
            head = []
        else:
            head.append(tokens[i])
        i += 1


def changes(text, body):
    """Possible changes of a function: {kind: [(offset, end, replacement with {id}), ...]}."""
    found, spots, open_brackets, statement = {}, [], [], 0

    def add(kind, start, end, new):
        found.setdefault(kind, []).append((start, end, new))

    def operand(i):
        """End of the right operand of a logical operator."""
        depth, stop = 0, {"||", ";", ",", "?", ":"} | ({"&&"} if body[i][0] == "&&" else set())
        for token in body[i + 1:]:
            if depth == 0 and (token[0] in stop or token[0] in ")}]"):
                return token.start()
            depth += {"(": 1, "[": 1, ")": -1, "]": -1}.get(token[0], 0)
            if token[0] in "{;":
                return None
        return None

    for i, token in enumerate(body):
        word, at, end = token[0], token.start(), token.end()
        before, after = (body[i - 1][0] if i else "{"), (body[i + 1][0] if i + 1 < len(body) else "}")
        if word in ("(", "[", "{"):
            block = word == "{" and (before in {")", ";", "{", "}", "else", "do", "const", "mutable", "try", ":"} or not i)
            loop = word == "(" and before == "for"
            open_brackets.append("block" if block else "for" if loop else word)
        elif word in (")", "]", "}") and open_brackets:
            open_brackets.pop()
        inner = open_brackets[-1] if open_brackets else "block"
        if before in {";", "{", "}"} and inner != "for":
            statement = i
            stop = re.search(r"[;{]", text[at:])
            line = text[at:at + stop.start() + 1] if stop else ""
            if re.fullmatch(r"[\w:.]+(->[\w.]+)*\((?:[^{])*\);", line) and inner == "block":
                add("statement", at, at, "if (!whorl_mutants::on({id})) ")
        line = text[body[statement].start():body[-1].end()].split(";")[0]
        if "[" in open_brackets or re.match(r"(static |const )*(constexpr|case|using|struct|template|enum|static_assert|static const)\b", line):
            continue
        words = '"' in line or re.search(r"string|path|name|text|begin\(|end\(|data\(", line)
        spaced = text[at - 1].isspace() and text[end:end + 1].isspace()
        k = body[i + 1].start() if i + 1 < len(body) else end
        if word in {"+", "-", "+=", "-="} and spaced and not words:
            add("sign", k, k, "whorl_mutants::either({id}, -1, 1) * ")
            add("term", k, k, "whorl_mutants::either({id}, 0, 1) * ")
        elif word == "-" and not spaced and before in {"(", ",", "=", "return", "?", ":"} and re.match(r"[A-Za-z_(]", after) and inner != "{":
            add("sign", at, end, "whorl_mutants::either({id}, 1, -1) * ")
        elif word in {"*", "/", "*=", "/="} and spaced and not words:
            add("factor", k, k, "whorl_mutants::either({id}, 2, 1) " + word[0] + " " if word in "*/" else "whorl_mutants::either({id}, 2, 1) * ")
        elif word in {"<", ">", "<=", ">="} and spaced and "for" not in open_brackets and not words:
            if after == "0" and text[k + 1] in " );,":
                add("bound", k, k + 1, "whorl_mutants::either({id}, 1, 0)")
            else:
                add("bound", k, k, "whorl_mutants::either({id}, 2, 1) * ")
        elif re.match(r"\.?\d", word) and inner != "{" and not re.search("[eExX]", word) and before != "<" and after != ">" and not words:
            changed = "1" + word[1:] if re.fullmatch(r"0[.0]*f?", word) else f"2 * {word}"
            if not (before in {"*", "/", "<", ">", "<=", ">=", "+", "-", "+=", "-="}):
                add("bound" if "for" in open_brackets else "factor", at, end, f"(whorl_mutants::on({{id}}) ? {changed} : {word})")
        elif word in {"&&", "||"} and spaced and (stop := operand(i)):
            rest = text[k:stop].rstrip()
            if "{" not in rest and '"' not in rest:
                add("condition", k, k + len(rest), ("(whorl_mutants::on({id}) || (" if word == "&&" else "(!whorl_mutants::on({id}) && (") + rest + "))")
        elif word == "if" and after == "(":
            depth, j = 0, i + 1
            while True:
                depth += {"(": 1, ")": -1}.get(body[j][0], 0)
                if depth == 0: break
                j += 1
            inside = text[k + 1:body[j].start()]
            if not re.search(r'[;{"]| = ', inside):
                add("condition", k + 1, body[j].start(), "!whorl_mutants::on({id}) && (" + inside + ")")
                add("condition", k + 1, body[j].start(), "whorl_mutants::on({id}) || (" + inside + ")")
        elif word in {"true", "false"} and before == "return" and after == ";":
            add("condition", at, end, f"(whorl_mutants::on({{id}}) != {word})")
        elif word in {"min", "max"} and text[at - 5:at] == "std::" and after == "(" and body[i + 2][0] != "{" and not words:
            add("bound", at - 5, k + 1, f"whorl_mutants::{word}({{id}}, ")
    if len(found) > 1:
        found.pop("statement", None)
    return found


def make(arguments):
    everything, files = [], subprocess.check_output(["git", "ls-files"], cwd=ROOT, text=True).split("\n")[:-1]
    functions_found = 0
    for file in files:
        if re.match(r"(engine|render)/.*\.cpp$", file):
            text = (ROOT / file).read_text()
            code = blank(text)
            for name, body in functions(code):
                functions_found += 1
                lot = random.Random(f"{arguments.seed} {file} {name} {len(everything)}")
                found = changes(code, body) if body else {}
                if found:
                    kind = lot.choice(sorted(found))
                    everything.append((file, name, kind, *lot.choice(found[kind])))
    print(f"{functions_found} functions, {len(everything)} with a spot to change")
    random.Random(arguments.seed).shuffle(everything)
    dropped = {int(i) for i in arguments.drop.split(",") if i}
    chosen = [(i, *m) for i, m in enumerate(everything, 1) if i not in dropped][:arguments.count]
    rows = []
    for file in files:
        text = (ROOT / file).read_bytes()
        here = sorted((m for m in chosen if m[1] == file), key=lambda m: -m[4])
        if here:
            text = text.decode()
            for id, _, name, kind, start, end, new in here:
                new = new.replace("{id}", str(id))
                line = text.count("\n", 0, start) + 1
                rows.append([id, f"{file}:{line}", name, kind, text.splitlines()[line - 1].strip(), new])
                text = text[:start] + new + text[end:]
            text = ('#include "engine/core/mutants.h"\n#line 1\n' + text).encode()
        write(arguments.out / file, text, ROOT / file)
    write(arguments.out / "engine/core/mutants.h", HEADER.encode())
    write(arguments.out / "engine/core/mutants.cpp", SOURCE.replace("COUNT", str(max(m[0] for m in chosen) + 1)).encode())
    with open(arguments.out / "mutants.csv", "w", newline="") as out:
        csv.writer(out).writerows([["id", "line", "function", "kind", "original", "change"]] + sorted(rows))


def write(path, content, like=None):
    """Writes only what differs, so that the next build is short."""
    if not path.exists() or path.read_bytes() != content:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        if like:
            shutil.copymode(like, path)


def tests_of(build):
    listed = json.loads(subprocess.check_output(["ctest", "--show-only=json-v1"], cwd=build, text=True))
    for test in listed["tests"]:
        properties = {p["name"]: p["value"] for p in test["properties"]}
        environment = dict(e.split("=", 1) for e in properties.get("ENVIRONMENT", []))
        for change in properties.get("ENVIRONMENT_MODIFICATION", []):
            key, value = change.split("=set:")
            environment[key] = value
        yield {"name": test["name"], "command": test["command"], "folder": properties.get("WORKING_DIRECTORY", build),
               "environment": environment, "long": "long" in properties.get("LABELS", [])}


def start(test, mutant, limit, reached=""):
    """Exit code (None: out of time) and processor time of a test."""
    environment = os.environ | test["environment"] | {"WHORL_MUTANT": str(mutant), "WHORL_REACHED": reached}
    began = time.monotonic()
    process = subprocess.Popen(test["command"], cwd=test["folder"], env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL, start_new_session=True,
                               preexec_fn=lambda: (resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 5)),
                                                   resource.setrlimit(resource.RLIMIT_CORE, (0, 0))))
    try:
        code = process.wait(4 * limit)
    except subprocess.TimeoutExpired:
        code = None
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    process.wait()
    return code, time.monotonic() - began


def stored(path):
    return list(csv.reader(open(path, newline=""))) if path.exists() else []


def run(arguments):
    out = arguments.out.resolve()
    lock = threading.Lock()
    results = arguments.results or out
    tests = {t["name"]: t for t in tests_of(out / "build/release") if arguments.long or not t["long"]}
    costs = {}
    for line in Path(arguments.costs or out / "build/release/Testing/Temporary/CTestCostData.txt").read_text().splitlines() if arguments.costs else []:
        if found := re.fullmatch(r"(.*) \d+ ([\d.e-]+)", line):
            costs[found[1]] = float(found[2])

    def append(name, row):
        with lock, open(results / name, "a", newline="") as file:
            csv.writer(file).writerow(row)

    def record(test):
        with tempfile.NamedTemporaryFile() as reached:
            code, seconds = start(test, -1, 600, reached.name)
            append("reached.csv", [test["name"], code, f"{seconds:.2f}", " ".join(sorted(set(reached.read().decode().split()), key=int))])

    known = {row[0] for row in stored(results / "reached.csv")}
    wanted = [t for n, t in sorted(tests.items(), key=lambda t: costs.get(t[0], 0)) if n not in known and costs.get(n, 0) <= arguments.seconds]
    with ThreadPoolExecutor(arguments.jobs) as pool:
        list(pool.map(record, wanted))

    useful = [(n, float(s), ids.split()) for n, code, s, ids in stored(results / "reached.csv") if code == "0" and n in tests]
    ran = {}
    for id, name, outcome, _ in stored(results / "runs.csv"):
        ran.setdefault(id, {})[name] = outcome

    def judge(id):
        spent = 0
        # A test that reaches few changes is more likely to be about this one.
        for name, seconds, ids in sorted((t for t in useful if id in t[2]), key=lambda t: t[1] * len(t[2])):
            done = ran.setdefault(id, {})
            if any(outcome != "passed" for outcome in done.values()):
                return
            if spent > arguments.budget:
                return
            if name not in done and costs.get(name, 0) <= arguments.seconds:
                code, seconds = start(tests[name], id, 5 * seconds + 20)
                done[name] = "passed" if code == 0 else "time" if code is None or code == -signal.SIGXCPU else "failed"
                append("runs.csv", [id, name, done[name], f"{seconds:.2f}"])
                spent += seconds

    with ThreadPoolExecutor(arguments.jobs) as pool:
        list(pool.map(judge, [m[0] for m in stored(out / "mutants.csv")[1:]]))
    table(arguments)


def table(arguments):
    results = arguments.results or arguments.out
    ran, reached = {}, set()
    for id, name, outcome, _ in stored(results / "runs.csv"):
        ran.setdefault(id, []).append((outcome, name))
    for row in stored(results / "reached.csv"):
        if row[1] == "0":
            reached.update(row[3].split())
    caught, living = {}, []
    for id, line, function, kind, original, new in stored(arguments.out / "mutants.csv")[1:]:
        failures = [name for outcome, name in ran.get(id, []) if outcome != "passed"]
        if failures:
            caught[id] = failures[0]
        else:
            living.append((id, line, function, kind, original, new, f"{len(ran.get(id, []))} tests" if id in reached else "not reached"))
    print(f"{len(caught)} caught, {sum(n.startswith('long') for n in caught.values())} of them by tests labelled long; {len(living)} live")
    for row in living:
        print(" | ".join(row))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["make", "run", "table"])
    parser.add_argument("out", type=Path, help="the changed tree")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--drop", default="", help="make: numbers of changes that do not compile")
    parser.add_argument("--seconds", type=float, default=1e9, help="run: only tests that take up to this")
    parser.add_argument("--budget", type=float, default=1e9, help="run: go on to the next change after so many seconds of tests")
    parser.add_argument("--costs", help="run: CTestCostData.txt of an earlier run of ctest, which says how long each test takes")
    parser.add_argument("--results", type=Path, help="run, table: folder of the results (default: the changed tree)")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--long", action="store_true")
    arguments = parser.parse_args()
    {"make": make, "run": run, "table": table}[arguments.command](arguments)
