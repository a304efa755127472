// The end of a link as the board sees it: docs/machines.md.
#pragma once

#include "stator/machines/end.hpp"

namespace stator::drivers::link::line {

// The nodes of a link are generated; this names their device.
struct LinkLine {
    using Device = machines::End;
};

}  // namespace stator::drivers::link::line
