#pragma once
/// The manual page and the shell's completion, from the same table of subcommands and options as --help.
#include <string>

namespace CLI {
class App;
}

namespace whorl {

/// whorl(1) in roff's man macros.
std::string man_page(const CLI::App& program);
/// A script for bash-completion: subcommands, their options, names of shipped scenes, files.
std::string bash_completion(const CLI::App& program);

}  // namespace whorl
