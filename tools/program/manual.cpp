#include <fmt/format.h>

#include "engine/core/version.h"
#include "engine/scene/read.h"
#include "tools/program/command.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {
namespace {

/// Escapes text for roff.
std::string roff(const std::string& text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if ((i == 0 || text[i - 1] == '\n') && (c == '.' || c == '\'')) out += "\\&";
        if (c == '\\') out += "\\e";
        else if (c == '-') out += "\\-";
        else out += c;
    }
    return out;
}

std::string names_of(const CLI::Option& option) {
    if (option.get_positional()) return option.get_type_name().empty() ? option.get_name() : option.get_type_name();
    std::string names;
    for (const std::string& name : option.get_snames()) names += (names.empty() ? "-" : ", -") + name;
    for (const std::string& name : option.get_lnames()) names += (names.empty() ? "--" : ", --") + name;
    return option.get_type_name().empty() || option.get_expected_max() == 0 ? names : names + " " + option.get_type_name();
}

std::string options_of(const CLI::App& app) {
    std::string text;
    for (const CLI::Option* option : app.get_options())
        text += fmt::format(".TP\n.B {}\n{}\n", roff(names_of(*option)), roff(option->get_description()));
    return text;
}

std::vector<const CLI::App*> commands_of(const CLI::App& program) {
    return program.get_subcommands([](const CLI::App* sub) { return !sub->get_group().empty(); });
}

std::string footer_of(const CLI::App& app) { return app.get_footer().empty() ? "" : ".PP\n.nf\n" + roff(app.get_footer()) + "\n.fi\n"; }

}  // namespace

std::string man_page(const CLI::App& program) {
    std::string text = fmt::format(".TH WHORL 1 \"\" \"whorl {}\" \"User Commands\"\n.SH NAME\nwhorl \\- {}\n", WHORL_VERSION,
                                   roff("videos of viscous fluids and vortices from a scene file"));
    text += ".SH SYNOPSIS\n.B whorl\n.I COMMAND\n.RI [ OPTIONS ]\n.SH DESCRIPTION\n" + roff(program.get_description()) + ".\n" +
            footer_of(program);
    text += ".SH OPTIONS\n" + options_of(program) + ".SH COMMANDS\n";
    for (const CLI::App* command : commands_of(program))
        text += fmt::format(".SS whorl {}\n{}\n{}{}", roff(command->get_name()), roff(command->get_description()), options_of(*command),
                            footer_of(*command));
    text +=
        ".SH EXIT STATUS\n.TP\n.B 0\ndone\n.TP\n.B 1\nthe machine or the run failed\n.TP\n.B 2\ninvalid scene or command line; "
        "nothing was written\n.TP\n.B 130\nstopped by Ctrl\\-C; the state is saved\n";
    return text;
}

std::string bash_completion(const CLI::App& program) {
    std::string commands, cases, scenes;
    for (const CLI::App* command : commands_of(program)) {
        commands += command->get_name() + " ";
        std::string words;
        for (const CLI::Option* option : command->get_options())
            for (const std::string& name : option->get_lnames()) words += (words.empty() ? "--" : " --") + name;
        cases += fmt::format("        {}) words=\"{}\" ;;\n", command->get_name(), words);
    }
    for (const std::string& name : film_names()) scenes += (scenes.empty() ? "" : " ") + name;
    return fmt::format(R"(# bash completion of whorl
_whorl() {{
    local word=$2 before=$3 words
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        mapfile -t COMPREPLY < <(compgen -W "{}help --help --version" -- "$word")
        return
    fi
    case $before in
        --quality) mapfile -t COMPREPLY < <(compgen -W "draft standard fine" -- "$word"); return ;;
        --export) mapfile -t COMPREPLY < <(compgen -W "{}" -- "$word"); return ;;
        --on) mapfile -t COMPREPLY < <(compgen -W "local slurm" -- "$word"); return ;;
        --out) mapfile -t COMPREPLY < <(compgen -d -- "$word"); return ;;
    esac
    case ${{COMP_WORDS[1]}} in
        help) mapfile -t COMPREPLY < <(compgen -W "{}" -- "$word"); return ;;
{}    esac
    case $word in
        -*) mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word") ;;
        *) mapfile -t COMPREPLY < <(compgen -W "{}" -- "$word"; compgen -f -- "$word") ;;
    esac
}}
complete -o filenames -F _whorl whorl
)",
                       commands, fmt::join(export_kinds(), " "), commands, cases, scenes);
}

void add_manual(CLI::App& program, Job& chosen) {
    const auto completion = std::make_shared<bool>(false);
    CLI::App* app = program.add_subcommand("manual", "print the manual page, for man -l, or with --bash a completion script");
    app->group("");  // hidden in --help: it serves the makers of packages
    app->add_flag("--bash", *completion, "print the script for bash-completion");
    app->callback([&program, completion, &chosen] {
        chosen = [&program, completion] {
            fmt::print("{}", *completion ? bash_completion(program) : man_page(program));
            return exit_done;
        };
    });
}

}  // namespace whorl
