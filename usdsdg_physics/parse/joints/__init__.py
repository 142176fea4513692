"""Read joints, what they couple, and which bodies they hold."""
