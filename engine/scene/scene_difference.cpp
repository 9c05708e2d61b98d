#include "engine/scene/scene_difference.h"

#include <map>

#include "engine/scene/names.h"
#include "engine/scene/read.h"

namespace whorl {
namespace {

void add_used_keys(const Described& here, const Described& root, const std::string& path, bool decides, std::vector<UsedKey>& all) {
    for (const Key& key : here.table->keys)
        if (counts(key, here, root)) all.push_back({{joined_path(path, key.name), key.get(here.object)}, &key, decides && key.decides});
    each_part(here, path, [&](const KeyTable::Part& part, const std::string& name, const Described& inner) {
        add_used_keys(inner, root, name, decides && part.decides, all);
    });
}

std::vector<UsedKey> deciding_keys(const Scene& scene) {
    std::vector<UsedKey> keys;
    const Described root{&scene_keys(), &scene};
    add_used_keys(root, root, "", keys);
    std::erase_if(keys, [](const UsedKey& k) { return !k.decides; });
    return keys;
}

std::vector<UsedKey> models_of(const Plan& plan) {
    const auto text = [](const char* name) { return Value(std::string(name)); };
    return {{{"models.pressure", text(name_of(plan.pressure))}},
            {{"models.viscosity", text(name_of(plan.viscosity))}},
            {{"models.micropolar", text(name_of(plan.micropolar))}},
            {{"models.boundary", text(name_of(plan.boundary))}},
            {{"models.shifting", text(name_of(plan.shifting))}},
            {{"fluid.kernel", text(name_of(plan.kernel.kind))}},
            {{"fluid.spacing", Value(plan.spacing)}},
            {{"fluid.support", Value(plan.support)}}};
}

}  // namespace

void add_used_keys(const Described& section, const Described& scene, const std::string& name, std::vector<UsedKey>& all) {
    add_used_keys(section, scene, name, true, all);
}

std::string KeyDifference::text() const {
    return path + ": " + (before ? before->toml() : "absent") + ", now " + (now ? now->toml() : "absent");
}

std::vector<KeyDifference> differences(const std::vector<UsedKey>& before, const std::vector<UsedKey>& now) {
    std::map<std::string, const UsedKey*> left;
    for (const UsedKey& k : before) left[k.path] = &k;
    std::vector<KeyDifference> found;
    for (const UsedKey& k : now) {
        const auto old = left.find(k.path);
        if (old == left.end()) found.push_back({k.path, {}, k.value, k.key});
        else if (old->second->value.toml() != k.value.toml()) found.push_back({k.path, old->second->value, k.value, k.key});
        left.erase(k.path);
    }
    for (const UsedKey& k : before)
        if (left.count(k.path) > 0) found.push_back({k.path, k.value, {}, k.key});
    return found;
}

std::vector<std::string> differences(const Scene& before, const Scene& now) {
    std::vector<std::string> lines;
    for (const KeyDifference& d : differences(deciding_keys(before), deciding_keys(now))) lines.push_back(d.text());
    return lines;
}

std::vector<KeyDifference> changes_of_models(const Plan& running, const Plan& wanted) {
    return differences(models_of(running), models_of(wanted));
}

}  // namespace whorl
