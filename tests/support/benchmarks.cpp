#include "tests/support/benchmarks.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "engine/probes/probes.h"
#include "engine/scene/read.h"

namespace whorl::test {

Scene shipped_scene(const std::string& name, const std::vector<std::string>& changes) {
    ReadRequest request;
    for (const std::string& change : changes) request.changes.push_back(parse_change(change));
    return read_scene(std::string(WHORL_SOURCE_DIR) + "/scenes/" + name + ".toml", request);
}

Simulation benchmark(const std::string& name, const std::vector<std::string>& changes) {
    const Scene scene = shipped_scene("studies/benchmarks/" + name, changes);
    return Simulation(scene, make_plan(scene));
}

Table reading(const Simulation& simulation, const std::string& probe) {
    for (const auto& [name, one] : make_probes(simulation, TheorySearch::wait)) {
        if (name != probe) continue;
        Table table;
        const ProbeColumns columns = one->columns();
        for (const std::vector<double>& row : rows_of(*one, simulation))
            for (std::size_t c = 0; c < columns.size(); ++c) table[columns[c].name].push_back(row[c]);
        return table;
    }
    throw std::invalid_argument("no probe " + probe);
}

Table reference(const std::string& name) {
    std::ifstream file(std::string(WHORL_SOURCE_DIR) + "/scenes/studies/benchmarks/" + name + ".csv");
    std::string line, cell;
    std::getline(file, line);
    std::vector<std::string> columns;
    for (std::istringstream head(line); std::getline(head, cell, ',');) columns.push_back(cell);
    Table table;
    while (std::getline(file, line)) {
        std::istringstream row(line);
        for (std::size_t c = 0; std::getline(row, cell, ','); ++c) table[columns.at(c)].push_back(std::stod(cell));
    }
    if (table.empty()) throw std::invalid_argument("no table " + name);
    return table;
}

double between(const std::vector<double>& places, const std::vector<double>& values, double x) {
    const auto above = static_cast<std::size_t>(std::lower_bound(places.begin(), places.end(), x) - places.begin());
    const std::size_t first = std::clamp<std::size_t>(above, 2, places.size() - 2) - 2;
    double sum = 0;
    for (std::size_t k = first; k < first + 4; ++k) {
        double part = values[k];
        for (std::size_t j = first; j < first + 4; ++j)
            if (j != k) part *= (x - places[j]) / (places[k] - places[j]);
        sum += part;
    }
    return sum;
}

}  // namespace whorl::test
