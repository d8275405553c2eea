// Random numbers of the tests: the same on every machine.
#pragma once

#include "simulation/random.h"

namespace eifmap::test {

using simulation::Random;

}  // namespace eifmap::test
