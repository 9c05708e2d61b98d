#pragma once
/// Results that must not depend on the number of threads.
#include "engine/core/parallel.h"

namespace whorl::test {

/// Whether work() returns equal values with 1, 2 and 4 threads.
template <class F>
bool same_on_threads(const F& work) {
    set_threads(1);
    const auto one = work();
    bool same = true;
    for (const int count : {2, 4}) set_threads(count), same = same && work() == one;
    set_threads(0);
    return same;
}

}  // namespace whorl::test
