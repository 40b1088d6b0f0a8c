// Limits of time steps that follow from the deck alone (scene/steps.hpp: those of the model).
#pragma once

#include <string>

#include "trackbed/input/deck.hpp"
#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

// Estimate of the stable sub-step, s: safety * sqrt(m/k) of a stone of the smallest sieve, to
// within a factor of 1.5 as long as the shapes of the stones are unknown. A contact of mass m and
// stiffness k is an oscillator for which central differences are stable up to 2 sqrt(m/k); several
// contacts at once and rotation reduce this limit, and the safety factor covers the rest.
double rough_step_limit(const Model& model);

// Limit of the window of the staggered coupling: 0.5 sqrt(m/(n k)) of the body for which it is
// shortest (sleeper; surface node of the ground, if it moves) on n contacts of the largest
// stiffness k. The load of a window acts one window late, which adds energy to an oscillator of
// frequency w at the rate w^2 dt/2; at this limit the damping of the contacts still dissipates
// more. For a ground's own vibrations see least_damping_of_ground.
struct CouplingLimit {
  double window;       // s, infinite if nothing moves
  std::string body{};  // "sleeper: mass 202 kg"
  // n, simultaneous. Sleeper: stones of the smallest sieve side by side on its face.
  double contacts = 1;
  double stiffness = 0;   // k, N/m
  std::string instead{};  // replaces the description of body and contacts
  std::string words() const;
};
CouplingLimit coupling_limit(const Model& model, bool ground_moves);
// Of a stage; with a train windows are at most `passage.step`, and a quarter of the stable step of
// rigid sleepers on the pads of the rail.
CouplingLimit coupling_limit(const Model& model, const Stage& stage);
// Of a body of this mass, kg, on so many simultaneous contacts.
CouplingLimit coupling_limit(const Model& model, const std::string& body, double mass,
                             double contacts);

enum class Modulus { known, from_file };
// s, coefficient of stiffness-proportional damping with which a solid of the ground dissipates what
// the delay of the stones' forces adds to its short waves, rounded up to two digits. Estimated from
// the deck; 0 if it has no waves so short, and for tetrahedra, for which there is no estimate.
double least_damping_of_ground(const Model& model, const fem::Elastic& solid, Modulus modulus);

// Throws InputError if the deck's sub-step is above `limit`, s, described by `words`.
void require_stable(const Model& model, const input::Deck& deck, double limit,
                    const std::string& words);

// Largest sieve of a layer, m.
double sieve_high(const bed::LayerParameters& layer);
// kg/m^3; of rock if the deck has no such material.
double density_of_stones(const Model& model, const bed::LayerParameters& layer);

}  // namespace trackbed::model
