#include <fmt/format.h>
#include <malloc.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <sstream>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/core/version.h"
#include "render/gl/renderer.h"
#include "tools/program/command.h"

namespace {

const char* const examples =
    "Examples:\n"
    "  whorl render honey_coil                       write images, video and diagnostics to out/honey_coil\n"
    "  whorl render honey_coil --quality draft --until 1 --set fluid.viscosity=300\n"
    "  whorl render my_scene.toml --out runs/a --size 1920x1080 --export mesh\n"
    "  whorl live thick_coil                         watch and change a run in a browser\n"
    "  whorl plan my_scene.toml                      print models, reasons and predicted cost\n"
    "  whorl resume runs/a                           continue after an interruption\n"
    "  whorl tradeoff coil_frequency --budget 10min  measure the cost of accuracy: sweep, Pareto front\n"
    "  whorl help render                             print a command's options and examples\n";

/// Hint with the subcommand or option nearest to an unexpected word; empty if none is near.
std::string hint_for(const CLI::App& at, const std::string& word) {
    std::vector<std::string> names;
    for (const CLI::App* sub : at.get_subcommands([](const CLI::App*) { return true; })) names.push_back(sub->get_name());
    for (const CLI::Option* option : at.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    const std::string near = whorl::nearest_name(word.substr(0, word.find('=')), names);
    return near.empty() ? "" : "; did you mean \"" + near + "\"?";
}

/// Instruction sets that this build requires of the processor. None is chosen at run time.
std::string processor_text() {
    std::string uses = "SSE2";
#ifdef __AVX2__
    uses += ", AVX2";
#endif
#ifdef __FMA__
    uses += ", FMA";
#endif
#ifdef __AVX512F__
    uses += ", AVX-512";
#endif
    if (WHORL_NATIVE) return "the one it was built on, or one with the same instruction sets; uses " + uses;
    return "any x86-64; uses " + uses;
}

std::string version_text() {
    std::string gl = "no working device; whorl doctor shows why";
    for (const whorl::DeviceAttempt& device : whorl::probe_devices())
        if (device.works) {
            gl = device.outcome;
            break;
        }
#ifdef __clang__
    const std::string compiler = __VERSION__;
#else
    const std::string compiler = fmt::format("gcc {}", __VERSION__);
#endif
    return fmt::format("whorl {}\nbuild      {}{}\nprocessor  {}\nprecision  {}\nGL         {}", WHORL_VERSION, compiler,
#ifdef __OPTIMIZE__
                       "",
#else
                       ", not optimised",
#endif
                       processor_text(), sizeof(whorl::Real) == 4 ? "float" : "double", gl);
}

/// Columns of the terminal; 0: lines are not wrapped.
std::size_t columns() {
    winsize size{};
    if (const char* given = std::getenv("COLUMNS")) return static_cast<std::size_t>(std::max(0, std::atoi(given)));
    return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

/// Breaks lines longer than `width` between words. Continuation lines are indented to the text of the right column, or to the line's first
/// word if there is one column.
std::string wrapped(const std::string& text, std::size_t width) {
    if (width < 20) return text;
    std::string out;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line); out += line + "\n") {
        const std::size_t first = std::min(line.find_first_not_of(' '), line.size()), gap = line.find("  ", first);
        std::size_t indent = gap == std::string::npos ? first : line.find_first_not_of(' ', gap);
        if (indent > width / 2) indent = first + 2;
        for (std::size_t end; line.size() > width; line = std::string(indent, ' ') + line.substr(end + 1)) {
            end = line.rfind(' ', width);
            if (end == std::string::npos || end <= indent) end = line.find(' ', width);
            if (end == std::string::npos) break;
            out += line.substr(0, end) + "\n";
        }
    }
    return out;
}

/// Prints help, version or the error. @return an ExitCode; 2 for every error of the command line
int end_of_parsing(CLI::App& program, const CLI::ParseError& e, const std::vector<std::string>& words) {
    if (e.get_exit_code() == 0) {  // --help, --version
        std::ostringstream text;
        program.exit(e, text, text);
        fmt::print("{}", wrapped(text.str(), columns()));
        return whorl::exit_done;
    }
    const CLI::App* at = &program;
    while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
    const std::string name = at == &program ? "whorl" : "whorl " + at->get_name();
    std::string what = e.what(), hint;
    if (const std::size_t colon = what.find(": must be "); colon != std::string::npos) what.erase(colon, 1);
    if (at == &program && !words.empty()) {
        what = (words[0][0] == '-' ? "unknown option \"" : "unknown subcommand \"") + words[0] + "\"";
        hint = hint_for(program, words[0]);
    } else if (const std::vector<std::string> left = at->remaining(); !left.empty()) {
        what = "unexpected argument \"" + left[0] + "\"";
        hint = hint_for(*at, left[0]);
    }
    fmt::print(stderr, "{}: {}{}; see {} --help\n", name, what, hint, name);
    return whorl::exit_bad_input;
}

}  // namespace

int main(int argc, char** argv) {
    signal(SIGCHLD, SIG_DFL);  // if inherited as ignored, child processes could not be waited for
    whorl::wait_passively(argv);
#ifdef __GLIBC__
    // Return blocks above 1 MB to the system when they are freed, which saves a sixth of the memory for 200,000 particles of water. By
    // default glibc keeps freed blocks of up to 32 MB each. Smaller blocks are kept, because a step with few particles would otherwise
    // request them from the system again and again.
    mallopt(M_MMAP_THRESHOLD, 1 << 20);
    mallopt(M_TRIM_THRESHOLD, 1 << 22);
#endif
    CLI::App program("Whorl: viscous coils and micropolar vortices, from a scene file to a video", "whorl");
    program.set_version_flag("--version", version_text, "print version, compiler, required processor, precision and GL device");
    program.footer(examples);
    program.require_subcommand(1);

    whorl::Job chosen;
    for (const auto add :
         {whorl::add_render, whorl::add_live, whorl::add_plan, whorl::add_resume, whorl::add_draw, whorl::add_video, whorl::add_import,
          whorl::add_farm, whorl::add_tradeoff, whorl::add_stability, whorl::add_schema, whorl::add_doctor, whorl::add_manual})
        add(program, chosen);
    std::vector<std::string> words{argv + 1, argv + argc};
    if (!words.empty() && words[0] == "help") {
        words.erase(words.begin());
        const auto named = [&](const CLI::App* command) { return words.empty() || command->get_name() == words[0]; };
        if (!program.get_subcommands(named).empty()) words.emplace_back("--help");
    }
    const int code = whorl::run_guarded([&] {
        try {
            program.parse(std::vector<std::string>(words.rbegin(), words.rend()));
        } catch (const CLI::ParseError& e) { return end_of_parsing(program, e, words); }
        return chosen();
    });
    if (code != whorl::exit_done || (std::fflush(stdout) == 0 && std::ferror(stdout) == 0)) return code;
    fmt::print(stderr, "whorl: standard output cannot be written: {}\n", std::generic_category().message(errno));
    return whorl::exit_failed;
}
