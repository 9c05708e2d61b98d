#include "tests/support/animated_nodes.h"

#include <cmath>
#include <cstdint>
#include <fstream>

namespace whorl::test {

int AnimatedNodes::node(const std::string& name, const nlohmann::json& more) {
    nlohmann::json node = more;
    node["name"] = name;
    json["nodes"].push_back(node);
    return static_cast<int>(json["nodes"].size()) - 1;
}

int AnimatedNodes::accessor(const std::vector<float>& numbers, int width) {
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", 4 * numbers.size()}});
    const char* const types[] = {"", "SCALAR", "", "VEC3", "VEC4"};
    json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                 {"componentType", 5126},
                                 {"count", numbers.size() / static_cast<std::size_t>(width)},
                                 {"type", types[width]}});
    binary_.append(reinterpret_cast<const char*>(numbers.data()), 4 * numbers.size());
    return static_cast<int>(json["accessors"].size()) - 1;
}

void AnimatedNodes::track(int node, const std::string& path, const std::vector<float>& times, const std::vector<float>& values,
                          const std::string& interpolation) {
    const int input = accessor(times, 1), output = accessor(values, path == "rotation" ? 4 : 3);
    json["animations"].push_back(
        {{"samplers", nlohmann::json::array({{{"input", input}, {"output", output}, {"interpolation", interpolation}}})},
         {"channels", nlohmann::json::array({{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}})}});
}

void AnimatedNodes::write(const std::filesystem::path& glb) const {
    nlohmann::json whole = json;
    whole["asset"]["version"] = "2.0";
    if (!binary_.empty()) whole["buffers"] = nlohmann::json::array({{{"byteLength", binary_.size()}}});
    std::string text = whole.dump();
    while (text.size() % 4 != 0) text += ' ';
    std::ofstream out(glb, std::ios::binary);
    const auto word = [&](std::size_t value) {
        const auto v = static_cast<std::uint32_t>(value);
        out.write(reinterpret_cast<const char*>(&v), 4);
    };
    word(0x46546C67), word(2), word(28 + text.size() + binary_.size());
    word(text.size()), word(0x4E4F534A), out << text;
    word(binary_.size()), word(0x004E4942), out << binary_;
}

AnimatedNodes turning_node(const std::string& name, double w, double end, const std::vector<double>& position) {
    AnimatedNodes file;
    const int node = file.node(name, {{"translation", position}}), rig = file.node("rig", {{"children", {node}}});
    std::vector<float> times, turns;
    const int keys = 1 + static_cast<int>(std::ceil(std::abs(w) * end));
    for (int k = 0; k <= keys; ++k) {
        const double t = end * k / keys;
        times.push_back(static_cast<float>(t));
        for (const double q : {0.0, std::sin(w * t / 2), 0.0, std::cos(w * t / 2)}) turns.push_back(static_cast<float>(q));
    }
    file.track(rig, "rotation", times, turns);
    return file;
}

}  // namespace whorl::test
