#include "options.h"
namespace eifmap {
std::string MapperOptions::problem() const { return ""; }
}
