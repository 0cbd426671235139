#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace bench {

/// Writes `report` to PREFIX.json, and each of its arrays of objects to PREFIX-NAME.csv: first under another name, so that
/// what lies there is whole at every moment. Throws std::runtime_error when it cannot.
void write_report(const nlohmann::ordered_json& report, const std::string& prefix);

}  // namespace bench
