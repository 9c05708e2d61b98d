#pragma once
/// Columns of the particle store by their names in files, independent of their type.
#include <algorithm>
#include <string>
#include <vector>

#include "engine/particles/store.h"

namespace whorl {

/// A column as numbers. value(i, c) is component c of particle i.
struct NumberColumn {
    std::string name;
    int components = 1;
    bool integer = false;
    std::size_t bytes = 0;  ///< per particle
    const void* data = nullptr;

    double value(Index i, int c = 0) const {
        const std::size_t k = static_cast<std::size_t>(i) * static_cast<std::size_t>(components) + static_cast<std::size_t>(c);
        if (!integer) return static_cast<double>(static_cast<const Real*>(data)[k]);
        if (bytes == 2) return static_cast<const std::int16_t*>(data)[k];
        return static_cast<const std::int32_t*>(data)[k];
    }
};

inline NumberColumn number_column(const ParticleStore::Entry& entry) {
    return {std::string(entry.info->name), entry.info->components, entry.info->integer, entry.info->bytes, entry.column->data()};
}

/// Names of quantities in files (scene file, probes, exports).
inline const std::vector<std::string>& quantity_names() {
    static const std::vector<std::string> names{"position",  "velocity",  "density", "pressure",   "spin",
                                                "vorticity", "viscosity", "ink",     "temperature"};
    return names;
}

/// The columns among `names` that the store has.
inline std::vector<NumberColumn> columns_named(const ParticleStore& store, const std::vector<std::string>& names) {
    std::vector<NumberColumn> found;
    for (const std::string& name : names)
        if (const ParticleStore::Entry* entry = store.find(name)) found.push_back(number_column(*entry));
    return found;
}

/// Fields that an export writes: lasting fields, and quantities with a name in files. Matrices are left out.
inline std::vector<std::string> live_fields(const ParticleStore& store) {
    std::vector<std::string> names = quantity_names();
    for (const ParticleStore::Entry* entry : store.entries()) {
        const std::string name(entry->info->name);
        if (entry->lasting && entry->info->components <= 3 && std::find(names.begin(), names.end(), name) == names.end())
            names.push_back(name);
    }
    std::erase_if(names, [&](const std::string& name) { return store.find(name) == nullptr; });
    return names;
}

/// "velocity_x", "velocity_y", "velocity_z"; or "density".
inline std::vector<std::string> component_names(const NumberColumn& column) {
    if (column.components == 1) return {column.name};
    std::vector<std::string> names;
    for (int c = 0; c < column.components; ++c)
        names.push_back(column.name + "_" + (column.components == 3 ? std::string(1, static_cast<char>('x' + c)) : std::to_string(c)));
    return names;
}

}  // namespace whorl
