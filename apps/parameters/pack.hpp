// The file of all parameters, piece by piece.
#pragma once

#include "parameters_ports.hpp"

namespace stator::apps::parameters {

// ArduPilot's `param.pck`: a head, then the parameters in the order of their ids, all numbers
// little-endian. Nothing of it is stored: each piece is computed from the beginning of the file.
// Its version is a hash of all values in it, so pieces of one version make one file.
FilePiece read_pack(const ParameterPort& parameters, const FileRequest& request);

}  // namespace stator::apps::parameters
