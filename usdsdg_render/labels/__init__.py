"""The label pass: AOVs and coverage masks."""
