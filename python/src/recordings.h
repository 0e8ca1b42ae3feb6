#pragma once
/// Recordings as columns of numpy.

#include "bindings.h"
#include "piste/core/log.h"

namespace piste::python {

/// The columns of a recording, named as those of csv with their units.
nb::dict table_of(const ImuRecording& imu);
nb::dict table_of(const GnssRecording& gnss);
nb::dict table_of(const AttitudeRecording& attitude);

}  // namespace piste::python
