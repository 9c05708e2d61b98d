#include <fmt/format.h>

#include "engine/scene/read.h"
#include "tools/program/command.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {
namespace {

int print_schema(const bool& markdown) {
    fmt::print("{}", markdown ? markdown_reference(known_sections()) : json_schema(known_sections()));
    return exit_done;
}

}  // namespace

void add_schema(CLI::App& program, Job& chosen) {
    const auto [app, markdown] =
        add_command(program, chosen, "schema", "print the JSON Schema of scene files, for editors", print_schema,
                    "Example:\n  whorl schema > scene.schema.json       then add as first line of a scene:  #:schema scene.schema.json");
    app.add_flag("--markdown", markdown, "print a page of all keys in Markdown instead");
}

}  // namespace whorl
