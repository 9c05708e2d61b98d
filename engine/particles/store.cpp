#include "engine/particles/store.h"

#include <algorithm>

namespace whorl {

void ParticleStore::declare(const FieldInfo& info, bool lasting) {
    Entry& entry = columns_[&info];
    if (!entry.column) {
        entry.info = &info;
        entry.lasting = lasting;
        entry.column = info.make();
        entry.column->resize(size_);
    }
    entry.lasting = entry.lasting || lasting;
}

void ParticleStore::resize(Index n) {
    for (auto& [info, entry] : columns_) entry.column->resize(n);
    size_ = n;
}

void ParticleStore::gather(Span<const Index> order) {
    for (auto& [info, entry] : columns_) entry.column->gather(order);
    size_ = static_cast<Index>(order.size());
}

std::vector<const ParticleStore::Entry*> ParticleStore::entries() const {
    std::vector<const Entry*> all;
    for (const auto& [info, entry] : columns_) all.push_back(&entry);
    std::sort(all.begin(), all.end(), [](const Entry* a, const Entry* b) { return a->info->name < b->info->name; });
    return all;
}

ParticleStore::Entry* ParticleStore::find(std::string_view name) {
    for (auto& [info, entry] : columns_)
        if (info->name == name) return &entry;
    return nullptr;
}

std::size_t ParticleStore::capacity_bytes() const {
    std::size_t bytes = 0;
    for (const auto& [info, entry] : columns_) bytes += entry.column->capacity_bytes();
    return bytes;
}

}  // namespace whorl
