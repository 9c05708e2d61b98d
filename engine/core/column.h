#pragma once
/// Arrays aligned to a cache line, so that vectorised loops give bit-identical results in every run.
#include <new>
#include <vector>

namespace whorl {

template <class T>
struct CacheAligned {
    using value_type = T;
    CacheAligned() = default;
    template <class U>
    CacheAligned(const CacheAligned<U>&) {}
    T* allocate(std::size_t n) { return static_cast<T*>(::operator new (n * sizeof(T), std::align_val_t{64})); }
    void deallocate(T* p, std::size_t) { ::operator delete (p, std::align_val_t{64}); }
    template <class U>
    bool operator==(const CacheAligned<U>&) const {
        return true;
    }
};
template <class T>
using Column = std::vector<T, CacheAligned<T>>;

/// values.resize(n). Growth reserves n/16 spare entries; std::vector would double the capacity.
template <class T>
void resize_tightly(Column<T>& values, std::size_t n) {
    if (n > values.capacity()) values.reserve(n + n / 16);
    values.resize(n);
}

}  // namespace whorl
