#pragma once
/// Reads summary.json and truth.json.

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>

namespace piste::test {

inline Eigen::Vector3d vector_of(const YAML::Node& node) {
  return {node[0].as<double>(), node[1].as<double>(), node[2].as<double>()};
}

}  // namespace piste::test
