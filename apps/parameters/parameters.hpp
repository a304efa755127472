// Publishes the parameters of all nodes, and changes them on request: the only node that does.
#pragma once

#include "keeper.hpp"
#include "parameters_ports.hpp"

namespace stator::apps::parameters {

// Answers each request with the value that counts from then on. A change is one publication of all
// parameters of the node whose parameter it is, before the answer. A value that is not of the
// parameter's type and range changes nothing. Records of an earlier life count as soon as they are
// loaded, and a change is kept as a record soon after its answer: `report` says when nothing is
// pending. The file of all parameters that ground stations read at once has them as they count now.
class Parameters {
  public:
    void step(ParametersPorts& ports);

  private:
    void answer(ParametersPorts& ports);
    void read_file(ParametersPorts& ports);

    Keeper keeper_;
};

}  // namespace stator::apps::parameters
