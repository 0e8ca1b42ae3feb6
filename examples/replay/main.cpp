// Reads a configuration and its logs, replays them, and prints where the body was every ten seconds.
//
//   replay ../../config/ski_run.yaml

#include <piste/piste.h>

#include <cstdio>
#include <exception>

namespace {

void print_row(const piste::Solution& solution, std::size_t row) {
  const piste::Navigation nav = solution.navigation(row);
  const piste::Sigmas sigmas = solution.sigmas(row);
  std::printf("%10.2f s  %11.7f deg  %11.7f deg  %8.3f m ± %.3f m   heading %7.2f ± %.2f deg\n", solution.time(row),
              nav.position.latitude * piste::kDegreesPerRadian, nav.position.longitude * piste::kDegreesPerRadian,
              nav.position.height, sigmas.position.z(), nav.euler.z() * piste::kDegreesPerRadian,
              sigmas.euler.z() * piste::kDegreesPerRadian);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: replay CONFIG\n");
    return 2;
  }
  try {
    const piste::Replay run = piste::replay(piste::read_replay_config(argv[1]));
    const piste::Solution& solution = run.solution();  // smoothed, unless the configuration says `smoother: none`
    std::printf("%s\n", run.found.how.c_str());
    double next = solution.time(0);
    for (std::size_t row = 0; row < solution.size(); ++row) {
      if (solution.time(row) < next) continue;
      next += 10;
      print_row(solution, row);
    }
  } catch (const piste::ConfigError& error) {  // the configuration is wrong
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  } catch (const piste::Error& error) {  // the data cannot be processed
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
