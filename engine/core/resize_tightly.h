#pragma once
/// Long columns that grow from step to step.
#include "engine/core/column.h"

namespace whorl {

/// values.resize(n) with a sixteenth to spare where it has to grow; the standard's doubles.
template <class T>
void resize_tightly(Column<T>& values, std::size_t n) {
    if (n > values.capacity()) values.reserve(n + n / 16);
    values.resize(n);
}

}  // namespace whorl
