// Publishes the parameters of all nodes, and changes them on request: the only node that does.
#pragma once

#include "parameters_ports.hpp"

namespace stator::apps::parameters {

// Answers each request with the value that counts from then on. A change is one publication of all
// parameters of the node whose parameter it is, before the answer. A value that is not of the
// parameter's type and range changes nothing. Without a request it does nothing.
class Parameters {
  public:
    void step(ParametersPorts& ports);
};

}  // namespace stator::apps::parameters
