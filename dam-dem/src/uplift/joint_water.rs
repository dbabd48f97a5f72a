use super::{Drains, Uplift, clipped, interpolate};

/// A straight joint and the water at its ends. Arrays of two have the upstream value first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointWater {
    /// Upstream and downstream end; y is the elevation above the heel of the dam, m.
    pub ends: [[f64; 2]; 2],
    /// Length along the joint, m.
    pub length: f64,
    /// Elevations of reservoir and tailwater above the heel of the dam, m. Water below an end of the joint
    /// exerts no pressure there.
    pub levels: [f64; 2],
    /// Specific weights γ of reservoir and tailwater, N/m³.
    pub specific_weights: [f64; 2],
}

impl JointWater {
    /// A joint between these `ends`.
    pub fn new(ends: [[f64; 2]; 2], levels: [f64; 2], specific_weights: [f64; 2]) -> Self {
        let [[x0, y0], [x1, y1]] = ends;
        Self { ends, length: (x1 - x0).hypot(y1 - y0), levels, specific_weights }
    }

    /// Static pressure (Pa) at the distance `x` from the upstream end, with cracks of the lengths `cracks`
    /// from the two ends: the line through [`nodes`](Self::nodes).
    pub fn pressure(&self, uplift: &Uplift, cracks: [f64; 2], x: f64) -> f64 {
        interpolate(&self.nodes(uplift, cracks), x)
    }

    /// Static pressure along the joint as a piecewise linear line: (distance from the upstream end, m;
    /// pressure, Pa). Two points at the same distance are a jump.
    ///
    /// ```text
    /// uncracked:                         γ H1, linear to γ H3 at the drains, linear to γ H2
    /// crack T that ends before drains:   γ H1 over T, then to γ H3, then to γ H2
    /// crack T that reaches the drains:   γ H1 over T, then linear to γ H2
    /// H3 = Hb + (1 − E)(H1 − Hb)(L − x_d)/L,  Hb = max(H2, gallery)
    /// ```
    ///
    /// with the heads H1 and H2 of reservoir and tailwater above the joint, and drains of efficiency E at
    /// x_d. Along a sloping joint the total head is linear between these places, at which it does not lie
    /// below the joint; pressure is never negative. A crack from the downstream end has the tailwater's
    /// pressure. A given profile is followed beyond the crack, from its next point on. A crack as long as the
    /// joint has the full pressure everywhere.
    ///
    /// **Source**: USACE EM 1110-2-2200, 1995, section 3-3.
    pub fn nodes(&self, uplift: &Uplift, cracks: [f64; 2]) -> Vec<[f64; 2]> {
        let length = self.length;
        let upstream = cracks[0].max(0.0).min(length);
        let downstream = cracks[1].max(0.0).min(length - upstream);
        let [start, end] = [upstream, length - downstream];
        let mut mouths = [self.end_pressure(0), self.end_pressure(1)];
        let mut inner = Vec::new();
        if let Some(profile) = &uplift.profile {
            mouths = [
                if upstream > 0.0 { mouths[0] } else { interpolate(profile, 0.0) },
                if downstream > 0.0 { mouths[1] } else { interpolate(profile, length) },
            ];
            inner.clone_from(profile);
        } else if let Some(drains) = &uplift.drains {
            inner.push([drains.position, self.drain_pressure(drains)]);
        }
        inner.retain(|&[x, _]| start < x && x < end);

        let mut line = vec![[0.0, mouths[0]]];
        if upstream > 0.0 {
            let tip = self.open_pressure(0, start);
            line.extend([[start, tip], [start, tip.max(0.0)]]);
        }
        line.append(&mut inner);
        if downstream > 0.0 {
            let tip = self.open_pressure(1, end);
            line.extend([[end, tip.max(0.0)], [end, tip]]);
        }
        if upstream < length {
            line.push([length, mouths[1]]);
        }
        let mut line = clipped(&line);
        line.dedup();
        line
    }

    /// Elevation of the joint at the distance `x` from its upstream end, m.
    pub fn elevation(&self, x: f64) -> f64 {
        let [[_, upstream], [_, downstream]] = self.ends;
        upstream + (downstream - upstream) * x / self.length
    }

    fn has_water(&self, end: usize) -> bool {
        self.levels[end] > self.ends[end][1]
    }

    /// Total head at an end: the water level, or the elevation of an end above it, m.
    fn head(&self, end: usize) -> f64 {
        self.levels[end].max(self.ends[end][1])
    }

    fn end_pressure(&self, end: usize) -> f64 {
        self.specific_weights[end] * (self.head(end) - self.ends[end][1])
    }

    /// Pressure in a crack from an end, at the distance `x` from the upstream end; negative above the water
    /// level.
    fn open_pressure(&self, end: usize, x: f64) -> f64 {
        if self.has_water(end) {
            self.specific_weights[end] * (self.levels[end] - self.elevation(x))
        } else {
            0.0
        }
    }

    /// Pressure at the drains before cracking, Pa.
    ///
    /// H3 of [`nodes`](Self::nodes) in terms of pressures, so that the two waters may have different specific
    /// weights. If the tailwater is the higher one, the two waters change roles. A gallery above both counts
    /// as at the higher level.
    fn drain_pressure(&self, drains: &Drains) -> f64 {
        let high = usize::from(self.head(1) > self.head(0));
        let low = 1 - high;
        let (weight, head) = match drains.gallery_elevation {
            Some(gallery) if gallery > self.head(low) => {
                (self.specific_weights[high], gallery.min(self.head(high)))
            }
            _ => (self.specific_weights[low], self.head(low)),
        };
        let mut ends = [self.end_pressure(high); 2];
        ends[low] = weight * (head - self.ends[low][1]);
        let undrained = ends[0] + (ends[1] - ends[0]) * drains.position / self.length;
        let drained = weight * (head - self.elevation(drains.position));
        (drained + (1.0 - drains.efficiency) * (undrained - drained)).max(0.0)
    }
}
