"""Robot motion in conformal geometric algebra."""
