#pragma once
/// How the checks note what is wrong with a scene's keys.
#include <utility>

#include "engine/core/errors.h"
#include "engine/scene/scene.h"

namespace whorl {

/// Called with a key ("solid[0].slip"), what is wrong with it, the way out and what is allowed; the last two may be left out.
class KeyProblems {
public:
    KeyProblems(const Scene& scene, std::vector<Problem>& problems) : scene_(scene), problems_(problems) {}
    void operator()(const std::string& key, std::string what, std::string hint = "", std::string allowed = "") const {
        problems_.push_back({scene_.place(key), std::move(what), std::move(hint), std::move(allowed)});
    }
    bool none() const { return problems_.empty(); }

private:
    const Scene& scene_;
    std::vector<Problem>& problems_;
};

}  // namespace whorl
