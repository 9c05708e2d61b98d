#pragma once
/// What a scene file may hold, for editors and as a page.
#include <string>
#include <vector>

#include "engine/scene/read.h"

namespace whorl {

/// JSON Schema (draft 7) of scene files, for editors.
std::string json_schema(const std::vector<Section>& sections = {});
/// The same keys as a page of Markdown tables.
std::string markdown_reference(const std::vector<Section>& sections = {});

}  // namespace whorl
