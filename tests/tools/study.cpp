#include "tools/study/study.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "engine/io/csv.h"
#include "tests/support/program.h"
#include "tests/support/scratch.h"
#include "tools/study/pareto_search.h"
#include "tools/study/point.h"

using namespace whorl;
using namespace whorl::test;
namespace fs = std::filesystem;

namespace study_test {

namespace {

void write(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
}

/// A short fall of a honey drop: cheap, with a known path.
const char* const falling =
    "name = \"falling\"\n[time]\nend = 0.1\nfps = 20\n[domain]\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n[fluid]\nspacing = 0.05\nviscosity = "
    "100\n"
    "[[block]]\nshape = \"sphere\"\nposition = [0, 0.5, 0]\nradius = 0.15\n"
    "[[probe]]\nname = \"all\"\nkind = \"region\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n";

/// A folder with that scene and a study of it.
struct StudyFolder : ScratchFolder {
    explicit StudyFolder(const std::string& text = "") {
        write(*this / "falling.toml", falling);
        write(*this / "study.toml", "scenes = [\"falling.toml\"]\n" + text);
    }
    Outcome run(const std::string& command, const std::vector<std::string>& more = {}, const std::string& out = "out") const {
        std::vector<std::string> words{command, *this / "study.toml", "--out", *this / out, "--threads", "1"};
        words.insert(words.end(), more.begin(), more.end());
        return test::whorl(words);
    }
};

const std::string max_step_knob = "[[knob]]\nkey = \"time.max_step\"\nvalues = ";
/// Free fall of the centroid: 0.5 - g t^2/2. A first-order integrator has an error of g t dt/2.
const char* const accuracy_of_fall = "[accuracy]\ntable = \"probes/all.csv\"\ncolumn = \"centroid_y\"\nexpected = \"0.5-9.81*t^2/2\"\n";

/// Replacement of sbatch that runs the job immediately; tests/farm/slurm.py uses the real one.
void write_sbatch(const fs::path& folder) {
    write(folder / "bin/sbatch", "#!/bin/sh\n[ \"$1\" = --version ] && exit 0\necho \"$@\" >> " + (folder / "asked").string() +
                                     "\necho sbatch: 12 hours are left of your account >&2\necho '7;north'\nfor word; do case $word in "
                                     "--output=*) out=${word#--output=};; --*) ;; *) break;; esac; shift; done\n"
                                     "exec sh \"$@\" > \"$out\" 2>&1\n");
    fs::permissions(folder / "bin/sbatch", fs::perms::owner_all);
}

}  // namespace

TEST_CASE("the Pareto front contains the points that no other beats in cost and error, and no failed run", "[study]") {
    const std::vector<Measured> points{{{0}, 1, 5}, {{1}, 2, 6}, {{2}, 3, 2}, {{3}, 4, 2}, {{4}, 5, 1}, {{5}, 0.1, NAN}};
    CHECK(pareto_front(points) == std::vector<std::size_t>{0, 2, 4});
}

TEST_CASE("the search finds the front of a smooth sweep with few runs off the front", "[study]") {
    // A finer spacing costs 8 times and quarters the error; a tighter tolerance costs 3 times and removes a small share. Of
    // the 30 points 14 are on the front.
    const auto cost = [](const GridPoint& p) { return std::pow(8.0, p[0]) * std::pow(3.0, p[1]); };
    const auto error = [](const GridPoint& p) { return 0.1 * std::pow(0.25, p[0]) + 0.002 * std::pow(0.3, p[1]); };
    const ParetoSearch search({5, 6});
    std::vector<Measured> found, all;
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 6; ++j) all.push_back({{i, j}, cost({i, j}), error({i, j})});
    for (GridPoint p; !(p = search.next(found)).empty();) {
        found.push_back({p, cost(p), error(p)});
        REQUIRE(found.size() <= all.size());
    }
    CHECK(found.size() <= 18);
    // Its front is at most a fifth worse than the true front, so more runs would gain little.
    for (const std::size_t k : pareto_front(all)) {
        double least = 1e9;
        for (const Measured& m : found) least = std::min(least, std::max(m.cost / all[k].cost, m.error / all[k].error));
        CHECK(least < 1.2);
    }
}

TEST_CASE("goals are read, and invalid goals are refused with an example", "[study]") {
    CHECK(parse_goal("error<2%").bound == Approx(0.02));
    CHECK(parse_goal("error < 0.02").holds(1, 0.019, 1));
    CHECK(parse_goal("fps>24").holds(1, 1, 25));
    CHECK_FALSE(parse_goal("cost<60").holds(61, 0, 1));
    CHECK_THROWS_WITH(parse_goal("speed>3"), "--recommend speed>3: is not a goal; allowed: \"error<2%\", \"fps>24\", \"cost<60\"");
    CHECK_THROWS_AS(parse_goal("error>2%"), InputError);
}

TEST_CASE("errors of a run refer to an expression, its first row, or a reference run", "[study]") {
    const ScratchFolder folder;
    write(folder / "a" / "diagnostics.csv", "frame,time,kinetic_energy\n1,0,10\n2,1,4\n3,2,1\n");
    write(folder / "b" / "diagnostics.csv", "frame,time,kinetic_energy\n1,0,10\n2,2,2\n");
    AccuracyKeys a;
    a.column = "kinetic_energy";
    a.expected = Expression("10*exp(-t)");
    CHECK(error_of(a, folder / "a", "") == Approx(std::abs(1 - 10 * std::exp(-2.0)) / (10 * std::exp(-2.0))));
    a.of = AccuracyKind::conserved;
    CHECK(error_of(a, folder / "a", "") == Approx(0.9));
    a.of = AccuracyKind::reference, a.at = Moment::all;
    CHECK(error_of(a, folder / "a", folder / "b") == Approx(std::sqrt((0 + 4 + 1) / 3.0) / 10));
    a.column = "kinetic_enrgy";
    CHECK_THROWS_WITH(error_of(a, folder / "a", ""), Catch::Contains("did you mean \"kinetic_energy\"?"));
}

TEST_CASE("a study runs its points once, writes table and images, recommends, and a second call keeps them", "[study]") {
    const StudyFolder folder("quality = \"draft\"\n" + max_step_knob + "[0.02, 0.01, 0.005]\n" + accuracy_of_fall);
    const std::string rock = "v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    const std::string scene =
        falling + std::string("[[solid]]\nshape = \"mesh\"\nfile = \"rock.obj\"\nscale = 0.1\nposition = [0, -0.9, 0]\n");
    write(folder / "rock.obj", rock);
    write(folder / "falling.toml", scene);
    const auto run = [&] { return test::succeed(folder.run("tradeoff", {"--all", "--recommend", "error<50%"})); };
    const Outcome first = run();
    const CsvTable table = read_csv(folder / "out" / "tradeoff.csv");
    REQUIRE(table.rows.size() == 3);
    for (const auto& row : table.rows) CHECK(row[table.index("error")] < 0.1);
    CHECK(fs::file_size(folder / "out" / "tradeoff.png") > 1000);
    CHECK(fs::exists(folder / "out" / "tradeoff.svg"));
    std::ifstream in(folder / "out" / "recommended.toml");
    const std::string overlay((std::istreambuf_iterator<char>(in)), {});
    CHECK(overlay.find("time.max_step = 0.0") != std::string::npos);
    CHECK_THAT(overlay, Catch::StartsWith("# error<50% of the study study: ") && Catch::Contains(", with --quality draft\n"));
    CHECK_THAT(first.out, Catch::Contains("recommended.toml --quality draft"));
    const auto point = [&](const std::string& extension) {
        for (const auto& entry : fs::directory_iterator(folder / "out" / "points"))
            if (entry.path().extension() == ".json") return entry.path().parent_path() / (entry.path().stem().string() + extension);
        throw std::runtime_error("no point has a record");
    };
    const auto change_record = [&](const char* key, const nlohmann::json& value) {
        std::ifstream record(point(".json"));
        nlohmann::json json = nlohmann::json::parse(record);
        json[key] = value;
        write(point(".json"), json.dump());
    };
    struct Case {
        const char* what;
        std::function<void()> edit;
        int kept;
    };
    const Case cases[]{
        {"nothing", [] {}, 3},
        {"a record, by hand", [&] { change_record("memory", "much"); }, 2},
        {"a run's folder was removed", [&] { fs::remove_all(point("")); }, 2},
        {"a run is of another call, which was interrupted", [&] { write(point("") / "run.json", "{\"status\": \"running\"}"); }, 2},
        {"a point failed", [&] { change_record("status", "failed"); }, 2},
        {"a point had less time", [&] { change_record("status", "timeout"), change_record("limit", 599); }, 2},
        {"the mesh that the scene names", [&] { write(folder / "rock.obj", "v 1 1 1\n" + rock); }, 0},
        {"the scene", [&] { write(folder / "falling.toml", scene + "density = 0\n"), write(folder / "rock.obj", rock); }, 0},
        {"a comment of the scene", [&] { write(folder / "falling.toml", "# slow\n" + scene); }, 3},
        {"a point had as much time", [&] { change_record("status", "timeout"); }, 3}};
    for (const Case& c : cases) {
        c.edit();
        INFO(c.what);
        const Outcome again = run();
        int kept = 0;
        for (std::size_t at = 0; (at = again.out.find("kept from an earlier sweep", at)) != std::string::npos; ++at) ++kept;
        CHECK(kept == c.kept);
    }
    // `whorl render` accepts the overlay.
    test::succeed({"render", (folder / "falling.toml").string(), "--with", (folder / "out" / "recommended.toml").string(), "--dry-run"});
}

TEST_CASE("the reference run may be a point of the grid", "[study]") {
    const StudyFolder folder(max_step_knob + "[0.01, 0.02, 0.005]\n[accuracy]\nof = \"reference\"\ntable = \"probes/all.csv\"\n" +
                             "column = \"centroid_y\"\nreference = [\"time.max_step=0.01\"]\n[cost]\nrepeat = 2\n");
    const Outcome done = test::succeed(folder.run("tradeoff", {"--jobs", "4", "--all", "--json"}));
    int kept = 0;
    const auto points = nlohmann::json::parse(done.out).at("points");
    for (const auto& point : points) {
        CHECK(point.at("status") == "done");
        const bool truth = point.at("settings").at(0) == "time.max_step=0.01";
        CHECK((point.at("error") == 0) == truth);
        CHECK(point.at("error") < 0.1);
        kept += point.at("kept").get<bool>();
    }
    CHECK(kept == 0);
}

TEST_CASE("a stability map separates stable from unstable steps, with the plan's limit in its table", "[study]") {
    // Explicit viscosity is stable to 0.125 R^2/(4 nu) = 3.1e-3 s here, R = 0.1 m, nu = 0.1 m^2/s.
    const StudyFolder folder(
        "set = [\"models.pressure=none\", \"models.viscosity=explicit\", \"block[0].velocity=['2*y','2*x','0']\", "
        "\"domain.gravity=[0,0,0]\"]\n[[knob]]\nkey = \"fluid.viscosity\"\nvalues = [100, 101]\n[[knob]]\nkey = \"time.fixed_step\"\n"
        "values = [2e-3, 5e-2]\n[stability]\nenergy_growth = 0.05\n");
    const Outcome map = test::succeed(folder.run("stability", {"--json"}));
    const auto cells = nlohmann::json::parse(map.out).at("cells");
    REQUIRE(cells.size() == 4);
    CHECK(cells[0].at("state") == "stable");
    CHECK(cells[1].at("state") == "stable");
    CHECK(cells[2].at("state") != "stable");
    CHECK(cells[2].at("first_bad_step").get<long>() > 0);  // time of the divergence, from the run's report
    CHECK(cells[0].at("first_bad_step").is_null());
    CHECK(cells[0].at("limits").at("viscous").get<double>() == Approx(3.1e-3).epsilon(0.05));
    CHECK(fs::file_size(folder / "out" / "stability.png") > 1000);
}

TEST_CASE("runs of a study go to Slurm as jobs, with the table of a run without it", "[study][farm]") {
    const StudyFolder folder("limit = 100\n" + max_step_knob + "[0.02, 0.01]\n" + accuracy_of_fall);
    write_sbatch(folder.path());
    const std::string path = std::getenv("PATH");
    setenv("PATH", ((folder / "bin").string() + ":" + path).c_str(), 1);
    const auto table = [&](const std::string& command, const std::string& name, const std::vector<std::string>& more) {
        test::succeed(folder.run(command, more, name));
        return read_csv(folder / name / (command + ".csv"));
    };
    std::vector<std::string> on_slurm{"--on", "slurm", "--jobs", "1", "--sbatch=--partition=short"};
    table("stability", "map", on_slurm);
    on_slurm.emplace_back("--all");
    const CsvTable here = table("tradeoff", "here", {"--all", "--on", "local"}), there = table("tradeoff", "there", on_slurm);
    setenv("PATH", path.c_str(), 1);
    REQUIRE(there.rows.size() == 2);
    for (std::size_t k = 0; k < 2; ++k) {
        CHECK(there.rows[k][there.index("time.max_step")] == here.rows[k][here.index("time.max_step")]);
        CHECK(there.rows[k][there.index("error")] == here.rows[k][here.index("error")]);
        CHECK(there.rows[k][there.index("cost")] > 0);
        CHECK(there.rows[k][there.index("memory_bytes")] > 1e6);
    }
    std::ifstream in(folder / "asked");
    std::string first;
    std::getline(in, first);
    CHECK(first.find("--wait --requeue") != std::string::npos);
    CHECK(first.find("--cpus-per-task=1") != std::string::npos);
    CHECK(first.find("--time=7 --partition=short") != std::string::npos);  // 100 s and 5 minutes to start, rounded up
    CHECK(first.find("timeout 100 ") != std::string::npos);

    CHECK_THAT(test::refusal(folder.run("stability", {"--on", "slrum"})), Catch::Contains("did you mean \"slurm\"?"));
    CHECK_THAT(test::refusal(folder.run("tradeoff", {"--sbatch=--partition=short"})),
               Catch::Contains("--sbatch: has no effect with --on local"));
}

TEST_CASE("the program of a point decides whether its scene is refused", "[study]") {
    // Too far from the origin for a program of single precision; this program has another message.
    const ScratchFolder folder;
    write(folder / "far.toml",
          "name = \"far\"\n[time]\nend = 0.1\n[domain]\nmin = [99999, -1, -1]\nmax = [100001, 1, 1]\n[fluid]\nspacing = 0.05\n"
          "[[block]]\nshape = \"sphere\"\nposition = [1e5, 0, 0]\nradius = 0.15\n");
    const std::vector<std::array<std::string, 4>> programs{{"other", "echo no fluid today; exit 2", "refused", "no fluid today"},
                                                           {"killed", "kill -KILL $$", "failed", "ended by signal 9 (out of memory?)"},
                                                           {"odd", "exit 255", "failed", "ended with code 255"},
                                                           {"saved", "exit 130", "failed", "ended with code 130"}};
    for (const auto& program : programs) {
        write(folder / program[0], "#!/bin/sh\n" + program[1] + "\n");
        fs::permissions(folder / program[0], fs::perms::owner_all);
    }
    write(folder / "map.toml",
          "scenes = [\"far.toml\"]\n[[knob]]\nkey = \"program\"\nvalues = [\"other\", \"killed\", \"odd\", "
          "\"saved\"]\n[stability]\nenergy_growth = 0.05\n");
    write_sbatch(folder.path());
    for (const char* more : {"map.toml --on local", "\"$PWD/map.toml\" --on slurm"}) {  // in its folder
        const std::string words = "cd \"$1\" && PATH=\"$1/bin:$PATH\" exec \"$0\" stability --out out --threads 1 --json ";
        const Outcome map = test::Program({"-c", words + more, WHORL_PROGRAM, folder.path().string()}, "/bin/sh").wait();
        INFO(more << map.err << map.out);
        REQUIRE(map.code == 0);
        const auto cells = nlohmann::json::parse(map.out).at("cells");
        for (std::size_t k = 0; k < programs.size(); ++k) {
            CHECK(cells.at(k).at("state") == programs[k][2]);
            CHECK_THAT(cells.at(k).at("why").get<std::string>(), Catch::Contains(programs[k][3]));
        }
    }
}

TEST_CASE("a study whose program was removed ends, and does not report refused points", "[study]") {
    const StudyFolder folder("[stability]\nenergy_growth = 0.05\n[[knob]]\nkey = \"time.cfl\"\nvalues = [0.2, 0.4]\n");
    const std::string study = folder / "study.toml", out = folder / "out", copy = folder / "gone";
    const Outcome gone =
        test::Program({"-c", "cp \"$0\" \"$1\" && exec 3< \"$1\" && rm \"$1\" && exec /proc/self/fd/3 stability \"$2\" --out \"$3\"",
                       WHORL_PROGRAM, copy, study, out},
                      "/bin/sh")
            .wait();
    CHECK(gone.code == 1);
    CHECK_THAT(gone.err, Catch::Contains("was removed") && Catch::Contains("start the study again"));
    CHECK_FALSE(fs::exists(folder / "out" / "stability.csv"));
}

TEST_CASE("braces in settings contain expressions of the knobs, or a knob's value", "[study]") {
    const std::vector<std::string> knobs{"d=1e-6", "time.fixed_step=0.5", "model=full"};
    CHECK(with_values("time.end={40*fixed_step}", knobs) == "time.end=20");
    CHECK(with_values("domain.min=[{-5*d}, 0, {2*sqrt(4)}]", knobs) == "domain.min=[-5e-06, 0, 4]");
    CHECK(with_values("models.viscosity={model}", knobs) == "models.viscosity=full");
    CHECK_THROWS_AS(with_values("{40*speed}", knobs), InputError);
    const std::vector<std::string> two{"block[0].radius=1", "solid[0].radius=2", "nu=3"};
    CHECK_THROWS_WITH(with_values("{2*radius}", two), Catch::Contains("two knobs are called radius; rename one of them"));
    CHECK_THROWS_WITH(with_values("{0.1*nu+0*(}", two), !Catch::Contains("two knobs"));
    CHECK(with_values("seed={radius}, {2*radius}", {"block[0].radius=1", "radius=4", "solid[0].radius=2"}) == "seed=4, 8");
}

TEST_CASE("a point uses scene, quality and seed of its settings, with scenes next to the study first", "[study]") {
    const StudyFolder folder;
    Study study;
    study.directory = folder.path(), study.quality = "draft";
    const PointCall own = point_call(study, "honey_coil", {"seed=3", "threads=2", "program=./x"});
    CHECK(own.options.scene == "honey_coil");
    CHECK(own.options.quality == "draft");
    CHECK(own.options.set == std::vector<std::string>{"seed=3"});
    CHECK(own.threads == "2");
    CHECK(fs::path(own.program) == folder / "./x");
    const Options other = point_call(study, "honey_coil", {"scene=falling.toml", "quality=fine", "time.end=1"}).options;
    CHECK(other.scene == (folder / "falling.toml").string());
    CHECK(other.quality == "fine");
    CHECK(other.set == std::vector<std::string>{"time.end=1"});
}

TEST_CASE("a study with a key without effect is refused, and a point that the plan refuses gives its reason", "[study]") {
    const std::string head = "[accuracy]\ncolumn = \"kinetic_energy\"\n[[knob]]\n";
    CHECK_THAT(StudyFolder(head + "key = \"scale\"\nvalues = [1, 2]\n").run("tradeoff").err, Catch::Contains("has no effect"));
    CHECK_THAT(test::refusal(StudyFolder(head + "key = \"fluid.spacing\"\nvalues = [-1, 0.05]\n").run("tradeoff")),
               Catch::Contains("fluid.spacing = -1"));
}

TEST_CASE("mistakes of a study file are reported together with their locations", "[study]") {
    const ScratchFolder folder;
    write(folder / "bad.toml",
          "scenes = []\nlimit = -1\n[[knob]]\nkey = \"a\"\nvalues = [1]\n[[knob]]\nkey = \"b\"\nvalues = [1, 2, 1]\n[acuracy]\n");
    CHECK_THAT(test::refusal({"tradeoff", (folder / "bad.toml").string(), "--out", (folder / "out").string()}),
               Catch::Contains("bad.toml:1:") && Catch::Contains("scenes is empty") && Catch::Contains("limit = -1 is out of range") &&
                   Catch::Contains("needs two values or more") && Catch::Contains("knob[1].values contains a value twice") &&
                   Catch::Contains("unknown key \"acuracy\"; did you mean \"accuracy\"?"));
    CHECK_FALSE(fs::exists(folder / "out"));
    write(folder / "names.toml", "scenes = [\"a.toml\", \"b/a.toml\"]\n");
    CHECK_THAT(test::whorl({"stability", (folder / "names.toml").string()}).err,
               Catch::Contains("names.toml:1:10: two of the scenes have the name a; give one of them another name"));
    std::string many = "[accuracy]\ncolumn = \"kinetic_energy\"\n";
    for (int k = 0; k < 12; ++k) many += "[[knob]]\nkey = \"emitter." + std::to_string(k) + ".speed\"\nvalues = [1, 2, 3, 4, 5]\n";
    CHECK_THAT(StudyFolder(many).run("tradeoff").err, Catch::Contains("the knobs have 2.4e+08 combinations of values"));

    const StudyFolder limits(
        "[[knob]]\nkey = \"time.fixed_step\"\nvalues = [1e-3, 2e-3]\n[stability]\nnoisy_speed = \"0.1*sped\"\nbisect = "
        "\"fluid.viscosity\"\n"
        "low = 1\nhigh = 10\n[[stability.limit]]\nname = \"right\"\nvalue = \"2*x*fixed_step\"\n[[stability.limit]]\nname = \"wrong\"\n"
        "value = \"2*xx\"\n");
    CHECK_THAT(test::refusal(limits.run("stability")),
               Catch::Contains("study.toml:6:15: stability.noisy_speed: {0.1*sped} is not an expression of the knobs") &&
                   Catch::Contains("study.toml:15:9: stability.limit[1].value: {2*xx} is not an expression of the knobs"));
    CHECK_FALSE(fs::exists(limits / "out"));
}

}  // namespace study_test
