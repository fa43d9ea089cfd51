"""What rclpy leaves undone: answers that reach slow clients, requests that are not lost."""
