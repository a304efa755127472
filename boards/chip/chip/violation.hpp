// What firmware did that the manual forbids or leaves undefined.
#pragma once

#include <stdexcept>
#include <string>

namespace stator::chip {

// Ends the run: on hardware, what follows is not known.
class Violation : public std::runtime_error {
  public:
    explicit Violation(const std::string& what) : std::runtime_error(what) {}
};

}  // namespace stator::chip
