#include "piste/align/aligned_pair.h"

#include "piste/condition/aligned_signals.h"
#include "piste/condition/pipeline.h"
#include "piste/core/error.h"
#include "piste/fit/phases.h"

namespace piste {

void for_each_pair(const AlignConfig& config, const std::function<void(std::size_t, std::size_t)>& progress,
                   const std::function<void(const AlignedPair&)>& take) {
  const auto report = [&](std::size_t done) {
    if (progress) progress(done, config.imus.size());
  };
  report(0);
  const Log reference = condition_imu(read_imu(config.reference.source), config.reference.conditioning);
  std::size_t done = 0;
  for (const MountedImu& imu : config.imus) {
    AlignedPair pair{.imu = imu,
                     .body = condition_imu(read_imu(imu.source), imu.conditioning).imu,
                     .reference = reference.imu,
                     .alignment = {},
                     .aligned = {},
                     .folder = config.imus.size() > 1 ? imu.name + "/" : ""};
    pair.alignment = align(pair.body, pair.reference,
                           {.sensor = imu.source.sensor,
                            .reference = config.reference.source.sensor,
                            .low_pass = config.low_pass,
                            .name = imu.source.log.file});
    pair.aligned = bring_together(pair.body, pair.reference, pair.alignment);
    take(pair);
    report(++done);
  }
}

Findings findings_of(const AlignConfig& config, const AlignedPair& pair) {
  const AlignedImus smooth = low_passed(pair.aligned, pair.alignment.low_pass);
  try {
    return findings(smooth, config.phases ? *config.phases : phases(smooth),
                    {.alignment = &pair.alignment,
                     .reference = &config.reference.source.sensor,
                     .sensor = &pair.imu.source.sensor});
  } catch (const DataError& e) {
    throw DataError(pair.imu.source.log.file, e.what());
  }
}

}  // namespace piste
