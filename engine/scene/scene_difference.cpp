#include "engine/scene/scene_difference.h"

#include <map>

#include "engine/scene/names.h"
#include "engine/scene/read.h"

namespace whorl {
namespace {

void add_used_keys(const Described& here, const Described& root, const std::string& path, bool decides, std::vector<UsedKey>& all) {
    for (const Key& key : here.table->keys)
        if (counts(key, here, root)) all.push_back({joined_path(path, key.name), &key, here.object, decides && key.decides});
    each_part(here, path, [&](const KeyTable::Part& part, const std::string& name, const Described& inner) {
        add_used_keys(inner, root, name, decides && part.decides, all);
    });
}

NamedTexts deciding_settings(const Scene& scene) {
    std::vector<UsedKey> keys;
    const Described root{&scene_keys(), &scene};
    add_used_keys(root, root, "", keys);
    NamedTexts settings;
    for (const UsedKey& k : keys)
        if (k.decides) settings.emplace_back(k.path, k.value().toml());
    return settings;
}

}  // namespace

void add_used_keys(const Described& section, const Described& scene, const std::string& name, std::vector<UsedKey>& all) {
    add_used_keys(section, scene, name, true, all);
}

std::string Difference::text() const { return name + ": " + (before ? *before : "absent") + ", now " + (now ? *now : "absent"); }

std::vector<Difference> differences(const NamedTexts& before, const NamedTexts& now) {
    std::map<std::string, std::string> left(before.begin(), before.end());
    std::vector<Difference> found;
    for (const auto& [name, text] : now) {
        const auto old = left.find(name);
        if (old == left.end()) found.push_back({name, std::nullopt, text});
        else if (old->second != text) found.push_back({name, old->second, text});
        if (old != left.end()) left.erase(old);
    }
    for (const auto& [name, text] : before)
        if (left.count(name) > 0) found.push_back({name, text, std::nullopt});
    return found;
}

std::vector<std::string> texts_of(const std::vector<Difference>& differences) {
    std::vector<std::string> lines;
    for (const Difference& d : differences) lines.push_back(d.text());
    return lines;
}

std::vector<std::string> differences(const Scene& before, const Scene& now) {
    return texts_of(differences(deciding_settings(before), deciding_settings(now)));
}

namespace {

/// Models that cannot change during a run, as in a scene file.
NamedTexts models_of(const Plan& plan) {
    const auto number = [](double value) { return Expression(value).text(); };
    return {{"models.pressure", name_of(plan.pressure)},     {"models.viscosity", name_of(plan.viscosity)},
            {"models.micropolar", name_of(plan.micropolar)}, {"models.boundary", name_of(plan.boundary)},
            {"models.shifting", name_of(plan.shifting)},     {"fluid.kernel", name_of(plan.kernel.kind)},
            {"fluid.spacing", number(plan.spacing)},         {"fluid.support", number(plan.support)}};
}

}  // namespace

std::vector<std::string> changes_of_models(const Plan& running, const Plan& wanted) {
    return texts_of(differences(models_of(running), models_of(wanted)));
}

}  // namespace whorl
