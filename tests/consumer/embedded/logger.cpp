#include <piste/math/earth.h>
#include <piste/piste.h>

#include <cmath>
#include <cstdio>

int main() {
  const piste::World world(piste::Geodetic{0.8, 0.1, 500});
  const double gravity = world.gravity(piste::Vector3d::Zero()).value.norm();
  std::printf("piste %s: %.4f m/s^2\n", piste::version().c_str(), gravity);
  return std::abs(gravity - 9.81) < 0.05 ? 0 : 1;
}
