#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "engine/scene/read.h"
#include "tools/program/command.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

void add_schema(CLI::App& program, Job& chosen) {
    const auto markdown = std::make_shared<bool>(false);
    CLI::App* app = program.add_subcommand("schema", "print the JSON Schema of scene files, for editors");
    app->add_flag("--markdown", *markdown, "print a page of all keys in Markdown instead");
    app->footer("Example:\n  whorl schema > scene.schema.json       then add as first line of a scene:  #:schema scene.schema.json");
    app->callback([markdown, &chosen] {
        chosen = [markdown] {
            fmt::print("{}", *markdown ? markdown_reference(known_sections()) : json_schema(known_sections()));
            return exit_done;
        };
    });
}

}  // namespace whorl
