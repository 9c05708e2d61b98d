/// whorl_studies FILE [SECTION]: measures again what the tables of a documentation page say. A table stands between the lines
/// <!-- begin NAME --> and <!-- end NAME -->.
#include <cstdio>
#include <functional>
#include <map>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/core/whole_file.h"
#include "engine/io/files.h"
#include "tools/studies/studies.h"

using namespace whorl;

namespace {

void replace_section(std::string& text, const std::string& name, const std::string& table) {
    const std::string begin = "<!-- begin " + name + " -->\n", end = "<!-- end " + name + " -->";
    const std::size_t from = text.find(begin), to = text.find(end);
    if (from == std::string::npos || to == std::string::npos)
        throw EnvironmentError("the page has no section \"" + name + "\"", "", "it stands between " + begin + "and " + end);
    text.replace(from + begin.size(), to - from - begin.size(), table);
}

}  // namespace

int main(int count, char** arguments) try {
    wait_passively(arguments);
    if (count < 2) {
        std::fprintf(stderr, "whorl_studies FILE [SECTION]\n");
        return 2;
    }
    const std::map<std::string, std::function<std::string()>> studies{{"curls", curl_table},
                                                                      {"refinement", refinement_table},
                                                                      {"refinement_street", refinement_street_table},
                                                                      {"preconditioners", preconditioner_table},
                                                                      {"preconditioners_large", preconditioner_table_large},
                                                                      {"hierarchies", hierarchy_table},
                                                                      {"divergence_free", divergence_free_table},
                                                                      {"threads", thread_table}};
    const std::string file = arguments[1];
    for (const auto& [name, table] : studies) {
        if (count > 2 ? name != arguments[2] : read_whole(file).find("<!-- begin " + name + " -->") == std::string::npos) continue;
        const std::string measured = table();  // the page may be edited while this takes its time
        std::string text = read_whole(file);
        replace_section(text, name, measured);
        write_text(file, text);
    }
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "whorl_studies: %s\n", error.what());
    return 1;
}
