#pragma once
/// Comparison of results between numbers of threads.
#include "engine/core/parallel.h"

namespace whorl::test {

/// Whether make() returns equal values on 1, 2 and 4 threads.
template <class Make>
bool same_on_threads(const Make& make) {
    set_threads(1);
    const auto first = make();
    bool same = true;
    for (const int count : {2, 4}) set_threads(count), same = make() == first && same;
    set_threads(0);
    return same;
}

}  // namespace whorl::test
