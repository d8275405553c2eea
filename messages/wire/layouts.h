// The layouts of messages that more than one reader walks over (layout.h).
#pragma once

#include "wire/layout.h"

namespace eifmap {

void scan_pose(LayoutScanner& in);
void scan_status(LayoutScanner& in);

}  // namespace eifmap
