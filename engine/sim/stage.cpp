#include "engine/sim/stage.h"

#include <set>

namespace whorl {

void declare_fields(const std::vector<Stage>& stages, ParticleStore& store) {
    std::set<const FieldInfo*> written;
    for (const Stage& stage : stages)
        for (const FieldAccess& a : stage.accesses) {
            store.declare(*a.field, a.access != Access::write && written.count(a.field) == 0);
            if (a.access != Access::read) written.insert(a.field);
        }
}

}  // namespace whorl
