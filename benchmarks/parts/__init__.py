"""Parts modelled with OCCT, scans of them, and the referee that scores reconstructions."""
