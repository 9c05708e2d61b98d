#pragma once
/// How long the next step may be.
namespace whorl {

/// Cuts a wanted step so that `remaining` is reached exactly and the last two steps before it are made equal.
/// @param wanted s, the smallest limit of the models @param remaining s, until the next frame time
inline double fitted_step(double wanted, double remaining) {
    // A sliver of a step (round-off) is worth no step of its own.
    if (wanted >= remaining * (1 - 1e-9)) return remaining;
    if (wanted > remaining / 2) return remaining / 2;
    return wanted;
}

}  // namespace whorl
