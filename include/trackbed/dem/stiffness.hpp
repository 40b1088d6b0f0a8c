// Largest stiffness of contacts, from which time steps follow.
#pragma once

#include <string>

#include "trackbed/dem/law.hpp"
#include "trackbed/dem/particles.hpp"

namespace trackbed::dem {

// The same materials and laws with this fraction, above 0, of the stiffness of all contacts;
// dampers keep their ratios.
Physics with_stiffness(Physics physics, double fraction);

// N/m, stiffness of the stiffest law. Hertz: k = F/delta on a contact of this radius (m) at the
// largest overlap allowed (fraction of the radius). Pairs of unknown materials do not count.
double stiffest_contact(const Physics& physics, double radius, double largest_overlap);

// s, largest sub-step: safety sqrt(m/k) of the lightest particle (kg) on the stiffest contact that
// particles up to this bounding radius (m) can have, over the largest damping ratio above 1.
// `limit`: the limiting case in words.
double stable_step(const Physics& physics, const Parameters& parameters, double lightest,
                   double largest, std::string* limit = nullptr);

// About the largest `safety` of that step with which compressed beds of stones with corners were
// observed to gain no energy (docs/decisions/time_step.md): many sticking contacts with dampers
// require a smaller step than one spring. The least of all linear laws; infinite without any.
double steady_safety(const Physics& physics);

// The largest `safety` with which the tangential dashpots of spheres are stable while the contact
// sticks; above it the tangential force changes its sign in each step. The least of all linear
// laws; infinite without any.
double steady_friction(const Physics& physics);

}  // namespace trackbed::dem
