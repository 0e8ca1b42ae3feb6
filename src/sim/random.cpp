#include "piste/sim/random.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace piste {
namespace {

// FNV-1a of the name, mixed with the seed by the finaliser of splitmix64.
std::uint64_t mix(std::uint64_t seed, std::string_view name) {
  std::uint64_t h = 0xcbf29ce484222325u;
  for (const char c : name) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  std::uint64_t z = h + seed * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::string_view name) : bits_(mix(seed, name)) {}

double RandomStream::uniform() { return (static_cast<double>(bits_() >> 11) + 0.5) * 0x1p-53; }

double RandomStream::normal() {
  if (std::exchange(has_spare_, false)) return spare_;
  const double radius = std::sqrt(-2 * std::log(uniform()));
  const double angle = 2 * std::numbers::pi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

Vector3d RandomStream::normal3() {
  const double x = normal(), y = normal(), z = normal();
  return {x, y, z};
}

DriftPath::DriftPath(const DriftProcess& process, RandomStream stream)
    : kind_(process.kind),
      scale_(Vector3d::Constant(kind_ == DriftProcess::Kind::kRandomWalk ? process.density : process.sigma)),
      correlation_time_(process.correlation_time),
      stream_(stream) {
  if (kind_ == DriftProcess::Kind::kGaussMarkov) value_ = scale_.cwiseProduct(stream_.normal3());
}

DriftPath::DriftPath(const GaussMarkov& process, RandomStream stream)
    : kind_(DriftProcess::Kind::kGaussMarkov),
      scale_(process.sigma),
      correlation_time_(process.correlation_time),
      stream_(stream),
      value_(scale_.cwiseProduct(stream_.normal3())) {}

const Vector3d& DriftPath::advance(double dt) {
  switch (kind_) {
    case DriftProcess::Kind::kNone:
      break;
    case DriftProcess::Kind::kRandomWalk:
      value_ += std::sqrt(dt) * scale_.cwiseProduct(stream_.normal3());
      break;
    case DriftProcess::Kind::kGaussMarkov: {
      const double decay = std::exp(-dt / correlation_time_);
      value_ = decay * value_ + std::sqrt(1 - decay * decay) * scale_.cwiseProduct(stream_.normal3());
      break;
    }
  }
  return value_;
}

}  // namespace piste
